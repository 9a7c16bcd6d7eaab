"""Reports of results, for people to read and check."""
