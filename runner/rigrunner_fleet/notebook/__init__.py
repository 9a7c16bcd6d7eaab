"""Runs for notebooks, with data frames and plots."""

from rigrunner_fleet.notebook.analysis import Analysis, analyse
from rigrunner_fleet.notebook.run import Run, open_run

__all__ = ["Analysis", "Run", "analyse", "open_run"]
