"""Raw against compensated torque over frequency."""

from __future__ import annotations

from math import isfinite, nan
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.figures import Axis, Figure, Mark, Picture, Point, Series
from rigrunner.signal.coverage import expanded
from rigrunner.signal.thinning import places_of_extremes
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.report.view.points import by_frequency
from rigrunner_reports.figures.results import MOST_POINTS, THINNED
from rigrunner_reports.numbers import fixed, stated

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.results import Result
    from rigrunner_bearings.report.view.points import SetPoint

DODGE = 0.007
"""Of the highest frequency: methods stand so far apart, or their bars hide each other."""
RIGHT = 1.045
"""The axis ends at so many times the highest frequency, or its bars are cut off."""


def over_frequency(result: Result, points: Sequence[SetPoint]) -> Picture:
    """Return the picture of raw and compensated torque, with truth and limits where there are."""
    torque = TorqueDetails.of(result)
    ordered = _points_to_draw(torque, by_frequency(points))
    names = [name for name, compensation in torque.compensations.items() if compensation.points]
    names.sort(key=lambda name: name != torque.primary)
    primary = names[:1] if torque.primary in names else []
    raw = Series.over(
        [point.frequency_hz for point in ordered],
        (point.raw_peak_nm for point in ordered),
        "raw peak",
        "joined",
    )
    compensated = [_method(ordered, name) for name in primary]
    lowest = min(p.y for series in (raw, *compensated) for p in series.points)
    methods = (
        _method(ordered, name, (place - (len(names) - 1) / 2) * DODGE * _highest_hz(ordered))
        for place, name in enumerate(names)
    )
    true = tuple(
        Point(point.frequency_hz, point.truth_nm) for point in ordered if point.truth_nm is not None
    )
    truth = [Series("simulated truth", true, "line")] if true else []
    bounds = None if result.decision is None else result.decision.deciding.limits
    limits = tuple(
        Mark("y", value, name=f"limit {bounds}", is_limit=True)
        for value in ((bounds.lower, bounds.upper) if bounds else ())
        if isfinite(value)
    )
    frequency = Axis("frequency", "Hz", low=0.0, high=RIGHT * _highest_hz(ordered) or None)
    panels = (
        Figure(
            "Raw and compensated",
            frequency,
            Axis("torque", "N·m", low=0.0 if lowest >= 0 else None),
            (*compensated, raw),
            limits,
        ),
        Figure(
            "Compensated by each method, enlarged",
            frequency,
            Axis("torque", "N·m"),
            (*methods, *truth),
            limits,
        ),
    )
    caption = _caption(torque, ordered) + (THINNED if len(ordered) < len(points) else "")
    return Picture(caption, _alt(torque, ordered), panels, in_a_row=True)


def _points_to_draw(torque: TorqueDetails, points: Sequence[SetPoint]) -> list[SetPoint]:
    """Return the set-points to draw: all, or of very many those where a torque is an extreme."""
    raw = np.array([point.raw_peak_nm for point in points])
    methods = [
        np.array(
            [
                point.by_method[name].torque.value if name in point.by_method else nan
                for point in points
            ]
        )
        for name, method in torque.compensations.items()
        if method.points
    ]
    return [points[place] for place in places_of_extremes(raw, *methods, most=MOST_POINTS)]


def _method(points: Sequence[SetPoint], name: str, dodge_hz: float = 0.0) -> Series:
    torques = [(point, point.by_method[name].torque) for point in points if name in point.by_method]
    return Series.over(
        (point.frequency_hz + dodge_hz for point, _ in torques),
        (torque.value for _, torque in torques),
        name,
        "joined",
        U=(expanded(torque) for _, torque in torques),
    )


def _highest_hz(points: Sequence[SetPoint]) -> float:
    return max(point.frequency_hz for point in points)


def _caption(torque: TorqueDetails, points: Sequence[SetPoint]) -> str:
    truth = (
        " The thin line is the simulated truth, which the analysis cannot see."
        if any(point.truth_nm is not None for point in points)
        else ""
    )
    return (
        "Torque over frequency. Left: the mean raw peak of a swing, and what is left of it by "
        f"{torque.primary or 'the primary method'}. Right: all methods on a larger scale, drawn "
        f"slightly apart. Bars are U (95 %).{truth}"
    )


def _alt(torque: TorqueDetails, points: Sequence[SetPoint]) -> str:
    raw = ", ".join(f"{p.frequency_hz:.4g} Hz {fixed(p.raw_peak_nm, 3)}" for p in points)
    methods = [f"Raw peak in N·m: {raw}."]
    for name, compensation in torque.compensations.items():
        if compensation.points:
            values = ", ".join(
                f"{point.frequency_hz:.4g} Hz {stated(point.by_method[name].torque).interval}"
                for point in points
                if name in point.by_method
            )
            methods.append(f"{name} in N·m: {values}.")
    return " ".join(methods)
