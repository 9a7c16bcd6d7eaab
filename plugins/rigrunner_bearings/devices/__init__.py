"""Simulated bearing testers."""
