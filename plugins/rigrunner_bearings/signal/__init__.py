"""Finds swings, their cycles and starts from rest in samples, and averages their torques."""
