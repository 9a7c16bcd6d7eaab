"""Golden runs: stored raw data through new software, and what moves against a reference."""
