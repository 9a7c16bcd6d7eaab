"""Instruments by protocol, replayed recordings, and devices that combine or wrap others."""
