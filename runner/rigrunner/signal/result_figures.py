"""Figures of the results of one name: over a coordinate, and relative to their limits."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING

from rigrunner.api.figures import Axis, Figure, Point, Series
from rigrunner.signal.coverage import expanded

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.findings import MeasurementResult
    from rigrunner.api.verdict import Limits

LEAST = 2
"""Fewest different values of a coordinate for a figure over it."""
Limited = tuple["MeasurementResult", "Limits | None", bool]
"""A result, its limits, and whether it is known to be outside of them."""


def over_coordinate(limited_results: Sequence[Limited]) -> tuple[Figure, ...]:
    """Return the figures of the results of one name; none if no coordinate is a number.

    The first figure shows the values. If each value has two limits, and their middle differs from
    value to value, a second one shows the distance of the values from the middle: on the scale of
    the first one the limits could not be distinguished.
    """
    axis = _axis([result for result, _, _ in limited_results])
    if axis is None:
        return ()
    first = limited_results[0][0]
    x_unit = first.coordinates[axis].unit
    groups: dict[str, list[Point]] = {}
    for result, limits, missed in limited_results:
        others = [str(value) for name, value in result.coordinates.items() if name != axis]
        x = float(result.coordinates[axis].in_unit(x_unit).value)
        width = expanded(result.estimate)
        ends = (None, None) if limits is None else (limits.lower, limits.upper)
        lower, upper = (end if end is not None and isfinite(end) else None for end in ends)
        point = Point(
            x=x,
            y=result.estimate.value,
            U=width if isfinite(width) else None,
            lower=lower,
            upper=upper,
            missed=missed,
        )
        groups.setdefault(", ".join(others), []).append(point)
    series = tuple(
        Series(name, tuple(sorted(points, key=lambda point: point.x)), "joined")
        for name, points in groups.items()
    )
    symbol, unit = first.of.symbol or first.name, first.of.unit
    values = Figure(first.of.title, Axis(axis, x_unit), Axis(symbol, unit), series)
    within = _within_limits(values, symbol, unit)
    return (values,) if within is None else (values, within)


def _within_limits(values: Figure, symbol: str, unit: str) -> Figure | None:
    points = [point for series in values.series for point in series.points]
    ends = {(point.lower, point.upper) for point in points}
    middles = {low + high for low, high in ends if low is not None and high is not None}
    if len(middles) < LEAST or any(low is None or high is None for low, high in ends):
        return None
    series = tuple(
        replace(line, points=tuple(map(_from_middle, line.points))) for line in values.series
    )
    # A difference of 1 °C is 1 K; as a temperature it would be 274.15 K.
    of_difference = "K" if unit == "°C" else unit
    axis = Axis(f"{symbol} \N{MINUS SIGN} middle of limits", of_difference)
    return Figure(f"{values.title} within its limits", values.x, axis, series)


def _from_middle(point: Point) -> Point:
    assert point.lower is not None  # noqa: S101  (checked by the caller)
    assert point.upper is not None  # noqa: S101  (checked by the caller)
    middle, half = (point.lower + point.upper) / 2, (point.upper - point.lower) / 2
    return replace(point, y=point.y - middle, lower=-half, upper=half)


def _axis(results: Sequence[MeasurementResult]) -> str | None:
    """Return the numerical coordinate with the most different values, the first of several."""
    best, most = None, LEAST - 1
    for name in results[0].coordinates if results else ():
        values = {result.coordinates[name].usual.value for result in results}
        if not any(isinstance(value, str) for value in values) and len(values) > most:
            best, most = name, len(values)
    return best
