"""The one home that draws figures of results: for reports, notebooks and files."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.plots.canvas import BLUE, GREY, VERMILION, drawn

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from rigrunner.api.data import Array
    from rigrunner.api.figures import Figure, Point, Series
    from rigrunner.plots.canvas import Plot

MOST_LINES = 8
"""So many series are drawn."""
_LIMIT: dict[str, Any] = {"color": VERMILION, "linestyle": (0, (5, 3)), "linewidth": 1.2}


def results(figures: Sequence[Figure]) -> Plot:
    """Return the plot of some figures, above each other."""

    def paint_all(canvas: Canvas) -> None:
        every = canvas.subplots(len(figures), squeeze=False)[:, 0]
        for axes, figure in zip(every, figures, strict=True):
            paint(axes, figure)
            axes.set_title(figure.title)
            if len(axes.get_legend_handles_labels()[1]) > 1:
                axes.legend()

    return drawn(paint_all, rows=2 * len(figures))


def paint(axes: Axes, figure: Figure) -> None:
    """Draw a figure: points with U as bars, curves with U as a band, limits as dashed lines.

    What misses its limits is crossed.
    """
    has_curve = any(each.is_line for each in figure.series)
    for each in figure.series[:MOST_LINES]:
        _paint(axes, each, joined=not has_curve)
    points = [point for series in figure.series for point in series.points]
    for x, limits in limit_lines((each.x, each.lower, each.upper) for each in points):
        if x:
            axes.plot(x, limits, **_LIMIT)
        else:
            axes.axhline(limits[0], **_LIMIT)
    if figure.has_limits:
        axes.plot([], [], label="limit", **_LIMIT)
    axes.set(xlabel=str(figure.x), ylabel=str(figure.y))
    axes.margins(x=0.06)


def limit_lines(
    limits: Iterable[tuple[float | None, float | None, float | None]],
) -> Iterator[tuple[list[float], list[float]]]:
    """Yield lines of limits: over x where they follow it, or one value without x for all.

    `limits` are x, lower and upper; x is None of a limit for all.
    """
    found = list(limits)
    sides = [(x, low) for x, low, _ in found], [(x, high) for x, _, high in found]
    for side in sides:
        known = {(x, value) for x, value in side if value is not None and isfinite(value)}
        values = sorted({value for _, value in known})
        placed = sorted((x, value) for x, value in known if x is not None)
        if len(values) > 1 and len(placed) == len(known):
            yield [x for x, _ in placed], [value for _, value in placed]
        else:
            yield from (([], [value]) for value in values)


def _paint(axes: Axes, series: Series, *, joined: bool) -> None:
    points = series.points
    x, y = _column(points, "x"), _column(points, "y")
    color = BLUE if not axes.lines else None
    if series.is_line:
        (line,) = axes.plot(x, y, color=color, label=series.name)
        half = np.nan_to_num(_column(points, "U"))
        axes.fill_between(x, y - half, y + half, color=line.get_color(), alpha=0.15, linewidth=0)
        return
    style = "-" if joined else "none"
    (line,) = axes.plot(x, y, linestyle=style, color=color, linewidth=1.0, alpha=0.6)
    bars = np.nan_to_num(_column(points, "U"))
    label = series.name or "result"
    axes.errorbar(x, y, yerr=bars, fmt="o", color=line.get_color(), ecolor=GREY, label=label)
    out = [index for index, each in enumerate(points) if each.missed]
    if out:
        axes.plot(x[out], y[out], "X", color=VERMILION, markersize=8, label="not within its limit")


def _column(points: Sequence[Point], name: str) -> Array:
    return np.array([getattr(each, name) for each in points], dtype=float)
