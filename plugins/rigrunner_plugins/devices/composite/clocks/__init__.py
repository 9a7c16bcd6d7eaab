"""Streams of several instruments on one time base, and how well it is known."""
