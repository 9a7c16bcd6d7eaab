"""Testers of bearings, simulated."""
