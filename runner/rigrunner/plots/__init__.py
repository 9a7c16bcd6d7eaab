"""Plots of arrays for notebooks and files; the figures of a report are its own."""

from rigrunner.plots.canvas import Plot
from rigrunner.plots.history import history
from rigrunner.plots.samples import samples
from rigrunner.plots.torque import torque_over_frequency

__all__ = ["Plot", "history", "samples", "torque_over_frequency"]
