"""JSON Schema, for editors, and descriptions of the files that people write."""
