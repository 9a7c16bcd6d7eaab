"""Trends over many runs: control charts and their rules, capability, gauge R&R."""
