"""What changed between two procedures, and between two runs."""
