"""Results over a coordinate, with their expanded uncertainty and the limits."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.coverage import expanded
from rigrunner_reports.numbers import plain, stated
from rigrunner_reports.plots.canvas import BLUE, GREY, VERMILION, Plot, draw
from rigrunner_reports.plots.thinning import MOST_POINTS, THINNED, places_of_extremes

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rigrunner.api.data import Array
    from rigrunner.api.findings import MeasurementResult
    from rigrunner.api.verdict import LimitDecision

LEAST = 2
MOST_LINES = 8
"""So many groups of further coordinates are drawn; the table has all."""


def over_coordinate(
    results: Sequence[MeasurementResult], parts: Sequence[LimitDecision]
) -> Plot | None:
    """Return the figure of results of one name; None where no coordinate is a number of several."""
    definition = results[0].of
    axis = _axis(results)
    if axis is None:
        return None
    missed = {id(part.result) for part in parts if not part.passes}
    x_unit = next(iter(results)).coordinates[axis].unit
    groups: dict[str, list[MeasurementResult]] = {}
    for each in results:
        others = [str(value) for name, value in each.coordinates.items() if name != axis]
        groups.setdefault(", ".join(others), []).append(each)
    symbol = definition.symbol or definition.name

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for name, found in list(groups.items())[:MOST_LINES]:
            _paint(axes, axis, name, found, missed)
        held = [(_at(part, axis), part.limits.lower, part.limits.upper) for part in parts]
        for where, limit in limit_lines(held):
            if where:
                axes.plot(where, limit, color=VERMILION, linestyle=(0, (5, 3)), linewidth=1.2)
            else:
                axes.axhline(limit[0], color=VERMILION, linestyle=(0, (5, 3)), linewidth=1.2)
        if parts:
            axes.plot([], [], color=VERMILION, linestyle=(0, (5, 3)), label="limit")
        unit = f" / {x_unit}" if x_unit not in {"", "1"} else ""
        axes.set(xlabel=f"{axis}{unit}", ylabel=f"{symbol} / {definition.unit}")
        handles, labels = axes.get_legend_handles_labels()
        if len(labels) > 1:
            figure.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4))

    thinned = any(len(found) > MOST_POINTS for found in groups.values())
    limits = " The dashed lines are the limits." if parts else ""
    bars = " The bars are U for 95 %."
    caption = f"{_capital(definition.words)} over {axis}.{bars}{limits}"
    alt = "; ".join(f"{each.place}: {stated(each.estimate)}" for each in results[:MOST_POINTS])
    return Plot(caption + (THINNED if thinned else ""), alt, draw(paint, 3.0))


def limit_lines(
    limits: Iterable[tuple[float | None, float, float]],
) -> Iterator[tuple[list[float], list[float]]]:
    """Yield lines of limits: over x where they follow it, or one value without x for all.

    `limits` are x, lower and upper; x is None of a limit for all.
    """
    found = list(limits)
    sides = [(x, low) for x, low, _ in found], [(x, high) for x, _, high in found]
    for side in sides:
        known = {(x, value) for x, value in side if isfinite(value)}
        values = sorted({value for _, value in known})
        placed = sorted((x, value) for x, value in known if x is not None)
        if len(values) > 1 and len(placed) == len(known):
            yield [x for x, _ in placed], [value for _, value in placed]
        else:
            yield from (([], [value]) for value in values)


def _at(part: LimitDecision, axis: str) -> float | None:
    place = part.coordinates.get(axis)
    return None if place is None or isinstance(place.value, str) else place.value


def _paint(
    axes: Axes, axis: str, name: str, found: Sequence[MeasurementResult], missed: set[int]
) -> None:
    ordered = sorted(found, key=lambda each: float(each.coordinates[axis].value))
    values = np.array([each.estimate.value for each in ordered])
    places = places_of_extremes(values, most=MOST_POINTS)
    shown = [ordered[place] for place in places]
    x = np.array([float(each.coordinates[axis].value) for each in shown])
    y = values[places]
    color = BLUE if not axes.lines else None
    (line,) = axes.plot(x, y, "-", color=color, linewidth=1.0, alpha=0.6)
    axes.errorbar(
        x,
        y,
        yerr=_bars(shown),
        fmt="o",
        color=line.get_color(),
        ecolor=GREY,
        label=name or "result",
    )
    out = [index for index, each in enumerate(shown) if id(each.estimate) in missed]
    if out:
        axes.plot(x[out], y[out], "X", color=VERMILION, markersize=8, label="not within its limit")


def _bars(results: Sequence[MeasurementResult]) -> Array:
    found = [expanded(each.estimate) for each in results]
    return np.array([each if isfinite(each) else 0.0 for each in found])


def _axis(results: Sequence[MeasurementResult]) -> str | None:
    """Return the coordinate that is a number and has the most values, the first of several."""
    best, most = None, LEAST - 1
    for name in results[0].coordinates:
        values = {each.coordinates[name].value for each in results}
        if not any(isinstance(value, str) for value in values) and len(values) > most:
            best, most = name, len(values)
    return best


def _capital(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}"


def span_text(values: Array, unit: str) -> str:
    """Return the range of values in words, for those who do not see a figure."""
    return f"{plain(float(values.min()))} to {plain(float(values.max()))} {unit}"
