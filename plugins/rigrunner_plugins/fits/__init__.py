"""Fits of y over x, such as torque over frequency."""
