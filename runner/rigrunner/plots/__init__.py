"""Plots of arrays and results, for notebooks and files, and those of results for reports too."""

from rigrunner.plots.canvas import Plot
from rigrunner.plots.history import history
from rigrunner.plots.results import results
from rigrunner.plots.samples import samples
from rigrunner.plots.torque import torque_over_frequency

__all__ = ["Plot", "history", "results", "samples", "torque_over_frequency"]
