"""Draws all figures: for reports, certificates, notebooks and files."""

from rigrunner.plots.canvas import Plot, draw

__all__ = ["Plot", "draw"]
