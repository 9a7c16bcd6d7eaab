"""Golden runs: regression tests of software on stored raw data."""
