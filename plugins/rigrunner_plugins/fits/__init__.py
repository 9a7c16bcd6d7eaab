"""Fits of torque over frequency."""
