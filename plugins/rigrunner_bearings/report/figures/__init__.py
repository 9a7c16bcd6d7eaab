"""Its figures as data, each with a text that says its numbers."""
