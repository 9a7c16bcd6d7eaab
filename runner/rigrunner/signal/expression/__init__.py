"""Formulas that people write, such as `b1*(1 - exp(-b2*x))`: read to a tree, never run."""
