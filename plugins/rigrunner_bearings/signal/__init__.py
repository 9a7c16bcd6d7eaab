"""Swings, their cycles and starts from rest in samples, and what their torques have in common."""
