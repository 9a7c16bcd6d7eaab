"""The figure of golden runs: changes of results, over all runs and at each set-point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.figures import Axis, Figure, Mark, Picture, Series
from rigrunner_reports.numbers import with_sign

if TYPE_CHECKING:
    from rigrunner.api.studies import GoldenStudy

MOST_RUNS = 300
"""Runs that are listed one by one."""
_EDGES = 41
_CAPTION = "{}ow many results moved by how much, in U of the reference.{} Shaded: within U."
_RIGHT = " Right, the mean over the runs and the largest of any run, at each set-point."


def in_u(value: float | None) -> str:
    """Return a change in expanded uncertainties."""
    if value is None:
        return "unknown"
    return f"{with_sign(value, 2)} U" if abs(value) >= 0.01 or not value else f"{value:+.1e} U"  # noqa: PLR2004  (two decimals)


def shifts(study: GoldenStudy) -> Picture:
    """Return the figure of the changes."""
    values = np.array(study.shifts_in_u)
    alt = f"{len(values)} results moved by {in_u(values.min())} to {in_u(values.max())}"
    caption = _CAPTION.format(*(("Left, h", _RIGHT) if study.set_points else ("H", "")))
    reach = max(float(np.abs(values).max()) * 1.1, 1.05)
    counts, edges = np.histogram(values, np.linspace(-reach, reach, _EDGES))
    distribution = Figure(
        "Shift of each result",
        Axis("shift", "U", low=-reach, high=reach),
        Axis("results"),
        (Series.over((edges[1:] + edges[:-1]) / 2, counts, kind="bars"),),
        (Mark("x", -1, 1),),
    )
    panels = (distribution, *([_set_points(study)] if study.set_points else []))
    return Picture(caption, alt, panels, in_a_row=True)


def _set_points(study: GoldenStudy) -> Figure:
    points = [
        (point.frequency_hz, point.mean_in_u, point.largest_in_u)
        for point in study.set_points
        if point.mean_in_u is not None and point.largest_in_u is not None
    ]
    hertz, means, largest = zip(*points, strict=True) if points else ((), (), ())
    reach = 1.1 * max(1.0, *map(abs, (*means, *largest)))
    return Figure(
        "Shift at each set-point",
        Axis("frequency", "Hz"),
        Axis("shift", "U", low=-reach, high=reach),
        (
            Series.over(hertz, means, "mean over the runs", "joined"),
            Series.over(hertz, largest, "largest of any run"),
        ),
        (Mark("y", 0.0), Mark("y", -1, 1)),
    )
