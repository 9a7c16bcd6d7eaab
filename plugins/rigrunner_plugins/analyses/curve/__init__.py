"""The analysis `curve`: fits a curve and derives results from it."""
