"""Comparing, sealing and signing documents and numbers."""
