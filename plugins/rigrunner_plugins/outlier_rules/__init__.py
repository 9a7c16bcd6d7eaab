"""Rules for gross errors."""
