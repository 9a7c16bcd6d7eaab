"""Swings, their cycles and starts from rest in samples, and the mean of their torques."""
