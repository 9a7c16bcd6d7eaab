"""The figures of a report as data, each with its numbers as text."""
