"""What the commands on many runs have in common: options, tables, progress."""
