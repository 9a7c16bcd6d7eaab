"""Rigrunner: a plugin-based runner of laboratory test procedures."""

from importlib.metadata import version

__version__ = version("rigrunner")
