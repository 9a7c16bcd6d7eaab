"""The kinds of steps of the language: one module each, found by their hook."""
