"""Simulated rigs and replay of recordings."""
