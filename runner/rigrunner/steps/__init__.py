"""The kinds of steps that the language has by itself: one module each, found by their hook."""
