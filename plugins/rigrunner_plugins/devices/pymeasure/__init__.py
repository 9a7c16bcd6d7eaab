"""Instruments for which PyMeasure has a driver: its properties as channels and drives."""
