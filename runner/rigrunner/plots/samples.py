"""Samples over time, however many there are."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.plots.canvas import BLUE, drawn

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.figure import Figure

    from rigrunner.api.data import Array
    from rigrunner.plots.canvas import Plot

_BUCKETS = 2000
"""More than a figure has pixels; of longer recordings the extremes of each are drawn."""


def samples(
    rate_hz: float, channels: Mapping[str, Array], units: Mapping[str, str], *, title: str = ""
) -> Plot:
    """Return the plot of channels of shape (n,) above each other, on one axis of time."""

    def paint(figure: Figure) -> None:
        every = figure.subplots(len(channels), sharex=True, squeeze=False)[:, 0]
        for axes, (name, values) in zip(every, channels.items(), strict=True):
            places, shown = extremes(values)
            axes.plot(places / rate_hz, shown, color=BLUE, linewidth=0.8)
            axes.set_ylabel(f"{name}\n/ {units.get(name, '1')}")
        every[0].set_title(title)
        every[-1].set_xlabel("time / s")

    return drawn(paint, rows=len(channels))


def extremes(values: Array) -> tuple[Array, Array]:
    """Return places and values to draw: all, or of very many the least and greatest of each part.

    So no peak is lost, as it would be if every n-th sample were taken.
    """
    if len(values) <= 2 * _BUCKETS:
        return np.arange(len(values), dtype=float), np.asarray(values, float)
    edges = np.linspace(0, len(values), _BUCKETS + 1).astype(int)
    found = [
        first + place
        for first, last in pairwise(edges)
        for place in sorted((np.argmin(values[first:last]), np.argmax(values[first:last])))
    ]
    places = np.array(found)
    return places.astype(float), np.asarray(values, float)[places]
