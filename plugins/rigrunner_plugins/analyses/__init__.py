"""The built-in analyses, which work for any quantity."""
