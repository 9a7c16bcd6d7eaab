"""Instruments by their protocols, simulated rigs, recordings again, and devices made of others."""
