"""Shared by the commands on many runs: options, tables, progress."""
