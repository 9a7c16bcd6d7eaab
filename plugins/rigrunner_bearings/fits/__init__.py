"""Fits that know the drive of a swing tester."""
