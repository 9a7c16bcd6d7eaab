"""The analysis `curve`: a fitted curve, and what follows from it."""
