"""Verification of runs and of documents on them."""
