"""A run, preflight or manual session in a process of its own, and what passes to and from it."""
