"""Curves for the screen, and the analysis of what was recorded so far."""
