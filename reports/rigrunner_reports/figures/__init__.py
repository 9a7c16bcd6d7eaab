"""The figures of a report as data, each with a text that says its numbers."""
