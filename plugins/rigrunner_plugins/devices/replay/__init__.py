"""A tester that plays back recordings from files."""
