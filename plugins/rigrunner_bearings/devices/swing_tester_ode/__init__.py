"""A second swing tester, formulated in the time domain and independent of the first."""
