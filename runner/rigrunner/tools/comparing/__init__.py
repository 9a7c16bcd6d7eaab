"""Compare two procedures, or two runs."""
