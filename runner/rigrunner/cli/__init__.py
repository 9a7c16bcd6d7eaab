"""The command line: the only floor, beside the panel, that renders errors."""
