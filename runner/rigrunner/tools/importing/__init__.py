"""Import recordings of another program as a run for the same analysis."""
