"""Runs for notebooks: `rigrunner.open_run` and `rigrunner.analyse`, with data frames and plots."""

from rigrunner.notebook.analysis import Analysis, analyse
from rigrunner.notebook.run import Run, open_run

__all__ = ["Analysis", "Run", "analyse", "open_run"]
