"""The figures of a report as SVG, each with a text that says its numbers."""
