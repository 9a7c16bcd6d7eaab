"""The live data of a running job: its state, curves and interim analysis."""
