"""Shared by instruments with text protocols: line ends, numbers, serial lines."""
