"""The figure of golden runs: how results moved, over all runs and at each set-point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator

from rigrunner_reports.numbers import with_sign
from rigrunner_reports.plots.canvas import BLUE, INK, VERMILION, Plot, draw

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rigrunner.api.studies import GoldenStudy

MOST_RUNS = 300
"""Runs that are listed one by one."""
_EDGES = 41
_CAPTION = "{}ow many results moved by how much, in U of the reference.{} Shaded: within U."
_RIGHT = " Right, the mean over the runs and the largest of any run, at each set-point."


def in_u(value: float | None) -> str:
    """Return a shift in expanded uncertainties."""
    if value is None:
        return "unknown"
    return f"{with_sign(value, 2)} U" if abs(value) >= 0.01 or not value else f"{value:+.1e} U"  # noqa: PLR2004  (two decimals)


def shifts(study: GoldenStudy) -> Plot:
    """Return the figure of the shifts."""

    def paint(figure: Figure) -> None:
        axes = figure.subplots(1, 2 if study.set_points else 1, squeeze=False)[0]
        _distribution(axes[0], study)
        if study.set_points:
            _set_points(axes[1], study)

    values = np.array(study.shifts_in_u)
    alt = f"{len(values)} results moved by {in_u(values.min())} to {in_u(values.max())}"
    caption = _CAPTION.format(*(("Left, h", _RIGHT) if study.set_points else ("H", "")))
    return Plot(caption=caption, alt=alt, svg=draw(paint, 3.3))


def _distribution(axes: Axes, study: GoldenStudy) -> None:
    values = np.array(study.shifts_in_u)
    reach = max(float(np.abs(values).max()) * 1.1, 1.05)
    axes.hist(values, bins=np.linspace(-reach, reach, _EDGES).tolist(), color=BLUE)
    axes.axvspan(-1, 1, color=INK, alpha=0.06, linewidth=0)
    axes.set(
        title="Shift of each result", xlabel="shift / U", ylabel="results", xlim=(-reach, reach)
    )
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def _set_points(axes: Axes, study: GoldenStudy) -> None:
    points = [
        (each.frequency_hz, each.mean_in_u, each.largest_in_u)
        for each in study.set_points
        if each.mean_in_u is not None and each.largest_in_u is not None
    ]
    axes.axhspan(-1, 1, color=INK, alpha=0.06, linewidth=0)
    axes.axhline(0, color=INK, linewidth=0.8)
    hertz = [hz for hz, _, _ in points]
    largest = [each for _, _, each in points]
    axes.plot(hertz, largest, "D", color=VERMILION, label="largest of any run")
    axes.plot(hertz, [mean for _, mean, _ in points], "o-", color=BLUE, label="mean over the runs")
    axes.set(title="Shift at each set-point", xlabel="frequency / Hz", ylabel="shift / U")
    reach = 1.1 * max(1.0, *np.abs(axes.get_ylim()).tolist())
    axes.set_ylim(-reach, reach)
    axes.legend(loc="best")
