"""Raw against compensated torque over frequency."""

from __future__ import annotations

from math import isfinite, nan
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.coverage import expanded
from rigrunner_reports.numbers import fixed, stated
from rigrunner_reports.plots.canvas import INK, PRIMARY, RAW, Line, Plot, draw, line_of
from rigrunner_reports.plots.thinning import MOST_POINTS, THINNED, places_of_extremes
from rigrunner_reports.view.points import by_frequency

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.legend import Legend

    from rigrunner.api.results import Result
    from rigrunner_reports.view.points import SetPoint

COLUMNS = 2
LEGEND_ROW = 0.08
"""Of the panel's height, what a row of the legend takes."""

DODGE = 0.007
"""Of the highest frequency: methods stand so far apart, or their bars hide each other."""
RIGHT = 1.045
"""The axis ends at so many times the highest frequency, or its bars are cut off."""


def over_frequency(result: Result, points: Sequence[SetPoint]) -> Plot:
    """Return the figure of raw and compensated torque, with truth and limit where there are any."""
    ordered = _shown(result, by_frequency(points))

    def paint(figure: Figure) -> None:
        left, right = figure.subplots(1, 2, width_ratios=(1, 1.25))
        _raw_and_compensated(left, result, ordered)
        _methods(right, result, ordered)

    caption = _caption(result, ordered) + (THINNED if len(ordered) < len(points) else "")
    return Plot(caption=caption, alt=_alt(result, ordered), svg=draw(paint, 3.3))


def _shown(result: Result, points: Sequence[SetPoint]) -> list[SetPoint]:
    """Return the set-points to draw: all, or of very many those where a torque is an extreme."""
    raw = np.array([each.raw_peak_nm for each in points])
    methods = [
        np.array([_torque_nm(each, name) for each in points])
        for name, method in result.compensations.items()
        if method.points
    ]
    return [points[place] for place in places_of_extremes(raw, *methods, most=MOST_POINTS)]


def _torque_nm(each: SetPoint, name: str) -> float:
    return each.by_method[name].torque.value if name in each.by_method else nan


def _raw_and_compensated(axes: Axes, result: Result, points: Sequence[SetPoint]) -> None:
    frequency = [each.frequency_hz for each in points]
    peaks = [each.raw_peak_nm for each in points]
    axes.plot(
        frequency, peaks, RAW.marker, color=RAW.color, linestyle=RAW.linestyle, label="raw peak"
    )
    if any(result.primary in each.by_method for each in points):
        _bars(axes, points, result.primary, f"compensated ({result.primary})", line=PRIMARY)
    _limits(axes, result, on_the_right=True)
    axes.set(title="Raw and compensated")
    if axes.dataLim.y0 >= 0:
        axes.set_ylim(bottom=0)
    _finish(axes, points)
    _room_for(axes.legend(loc="upper left"), axes)


def _methods(axes: Axes, result: Result, points: Sequence[SetPoint]) -> None:
    names = [name for name, each in result.compensations.items() if each.points]
    for place, name in enumerate(names):
        dodge = (place - (len(names) - 1) / 2) * DODGE * _highest_hz(points)
        line = line_of(name, names, result.primary)
        _bars(axes, points, name, name, line=line, dodge_hz=dodge)
    true = [(each.frequency_hz, each.truth_nm) for each in points if each.truth_nm is not None]
    if true:
        axes.plot(*np.transpose(true), color=INK, linewidth=0.9, label="simulated truth", zorder=5)
    _limits(axes, result)
    axes.set(title="Compensated by each method, enlarged")
    _finish(axes, points)
    axes.margins(y=0.1)
    _room_for(axes.legend(loc="upper center", ncols=COLUMNS), axes, COLUMNS)


def _room_for(legend: Legend, axes: Axes, columns: int = 1) -> None:
    """Let a legend stand above all curves."""
    rows = -(-len(legend.get_texts()) // columns)
    low, high = axes.get_ylim()
    axes.set_ylim(low, low + (high - low) / (1 - LEGEND_ROW * rows))


def _bars(
    axes: Axes,
    points: Sequence[SetPoint],
    name: str,
    label: str,
    *,
    line: Line,
    dodge_hz: float = 0,
) -> None:
    found = [each.by_method[name] for each in points if name in each.by_method]
    axes.errorbar(
        [each.frequency_hz + dodge_hz for each in found],
        [each.torque.value for each in found],
        yerr=[_finite(expanded(each.torque)) for each in found],
        label=label,
        elinewidth=1,
        color=line.color,
        linestyle=line.linestyle,
        marker=line.marker,
    )


def _finite(value: float) -> float:
    return value if isfinite(value) else 0.0


def _limits(axes: Axes, result: Result, *, on_the_right: bool = False) -> None:
    """Draw the limits, each named on its side away from the result, which it would hide.

    Raw peaks stand nearest to the result on the left, where the no-load torque is small.
    """
    if result.decision is None:
        return
    limits, mean = result.decision.deciding.limits, result.headline
    for value in (limits.lower, limits.upper):
        if isfinite(value):
            is_above = mean is None or value >= mean.value
            axes.axhline(value, color=INK, linewidth=1.1, linestyle=(0, (6, 3)), zorder=1)
            axes.annotate(
                f"limit {limits}",
                (float(on_the_right), value),
                xycoords=("axes fraction", "data"),
                xytext=(-4 if on_the_right else 4, 3 if is_above else -3),
                textcoords="offset points",
                ha="right" if on_the_right else "left",
                va="bottom" if is_above else "top",
                fontsize=7.5,
            )


def _finish(axes: Axes, points: Sequence[SetPoint]) -> None:
    axes.set(xlabel="frequency / Hz", ylabel="torque / N·m")
    axes.set_xlim(0, RIGHT * _highest_hz(points) or None)


def _highest_hz(points: Sequence[SetPoint]) -> float:
    return max(each.frequency_hz for each in points)


def _caption(result: Result, points: Sequence[SetPoint]) -> str:
    truth = (
        " The thin line is the simulated truth, which the analysis cannot see."
        if any(each.truth_nm is not None for each in points)
        else ""
    )
    return (
        "Torque over frequency. Left: the mean raw peak of a swing, and what is left of it by "
        f"{result.primary or 'the primary method'}. Right: all methods on a larger scale, drawn "
        f"slightly apart. Bars are U (95 %).{truth}"
    )


def _alt(result: Result, points: Sequence[SetPoint]) -> str:
    raw = ", ".join(f"{each.frequency_hz:.4g} Hz {fixed(each.raw_peak_nm, 3)}" for each in points)
    methods = [f"Raw peak in N·m: {raw}."]
    for name, compensation in result.compensations.items():
        if compensation.points:
            values = ", ".join(
                f"{each.frequency_hz:.4g} Hz {stated(each.by_method[name].torque).interval}"
                for each in points
                if name in each.by_method
            )
            methods.append(f"{name} in N·m: {values}.")
    return " ".join(methods)
