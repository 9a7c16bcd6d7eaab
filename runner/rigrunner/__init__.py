"""Rigrunner: a plugin-based runner of laboratory test procedures."""

__version__ = "0.1.0"
