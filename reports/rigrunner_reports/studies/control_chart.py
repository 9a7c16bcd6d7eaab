"""The figure of a control chart: values with their limits, and below them their differences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.figures import Axis, Figure, Mark, Picture, Point, Series
from rigrunner.signal.thinning import places_of_extremes
from rigrunner_reports.numbers import as_scattered

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.studies import Trend, TrendSeries

MOST = 400
"""The most points that are drawn."""
MOST_WITH_BARS = 120
"""The most points with bars of uncertainty: more would make a band."""


def control_chart(trend: Trend, series: TrendSeries) -> Picture:
    """Return the figure of one series, over the number of a run in the series."""
    weighted = trend.chart == "ewma"
    shown = _shown(series)
    run = Axis("run", low=0, high=len(series.points) + 1)
    title = "Weighted mean of the values" if weighted else "Values"
    axis = Axis("value", trend.unit)
    baseline = [number for number, point in enumerate(series.points, 1) if point.baseline]
    marks = (
        Mark("x", baseline[0] - 0.5, baseline[-1] + 0.5, "baseline"),
        Mark("y", series.individuals.centre, name="centre"),
    )
    values = Figure(title, run, axis, tuple(_values(series, shown, weighted=weighted)), marks)
    panels = (values,) if weighted else (values, _ranges(series, shown, run, trend.unit))
    return Picture(_caption(series, weighted=weighted), _alt(series), panels)


def _shown(series: TrendSeries) -> list[int]:
    """Return the indices to draw: all, or for very many the extremes and those with a rule."""
    values = np.array([point.observed.value for point in series.points])
    plotted = np.array([point.plotted for point in series.points])
    met = np.flatnonzero([bool(point.rules) for point in series.points])
    drawn = met[places_of_extremes(plotted[met], most=MOST)].tolist()
    return sorted({*places_of_extremes(values, plotted, most=MOST).tolist(), *drawn})


def _values(series: TrendSeries, shown: list[int], *, weighted: bool) -> Iterator[Series]:
    numbered = [(place + 1, series.points[place]) for place in shown]
    has_bars = not weighted and len(shown) <= MOST_WITH_BARS
    has_u = has_bars and any(point.observed.expanded is not None for _, point in numbered)
    name = "weighted mean" if weighted else "value, with its U (95 %)" if has_u else "value"
    points = (
        Point(
            number,
            point.plotted,
            point.observed.expanded if has_bars else None,
            point.lower,
            point.upper,
        )
        for number, point in numbered
    )
    yield Series(name, tuple(points), "joined")
    if weighted:
        single = [point.observed.value for _, point in numbered]
        yield Series.over([number for number, _ in numbered], single, "single value")
    met = [Point(number, point.plotted) for number, point in numbered if point.rules]
    if met:
        yield Series("a rule is met", tuple(met), "marked")


def _ranges(series: TrendSeries, shown: list[int], run: Axis, unit: str) -> Figure:
    ranges = [(place + 1, series.points[place].moving_range) for place in shown]
    drawn = tuple(Point(number, width) for number, width in ranges if width is not None)
    limits = series.moving_range
    return Figure(
        "Moving range",
        run,
        Axis("difference", unit, low=0.0),
        (Series("", drawn, "joined"),),
        (Mark("y", limits.centre), Mark("y", limits.upper, name="limit", is_limit=True)),
    )


def _caption(series: TrendSeries, *, weighted: bool) -> str:
    what = (
        "Exponentially weighted mean of the values, with its limits, which widen to their last "
        "width"
        if weighted
        else "Values of the runs in the order of time, between three standard deviations"
    )
    ranges, sigma = series.moving_range, series.individuals.sigma
    below = (
        ""
        if weighted
        else " Below: how far each run is from the one before; the mean of the baseline is "
        f"{as_scattered(ranges.centre, sigma)}, the limit {as_scattered(ranges.upper, sigma)}."
    )
    thinned = (
        " Of the many runs, and of those at which a rule is met, the least and the greatest of "
        "equal stretches are drawn."
        if len(series.points) > MOST
        else ""
    )
    return (
        f"{series.name}. {what}. The limits are made of the baseline, on the blue ground, alone."
        + below
        + thinned
    )


def _alt(series: TrendSeries) -> str:
    limits = series.individuals
    sigma = limits.sigma
    met = ", ".join(f"{run.observed.run_id} ({', '.join(run.rules)})" for run in series.alarms)
    return (
        f"{len(series.points)} values about {as_scattered(limits.centre, sigma)}, limits "
        f"{as_scattered(series.points[-1].lower, sigma)} and "
        f"{as_scattered(series.points[-1].upper, sigma)}. "
        f"Rules met after the baseline: {met or 'none'}."
    )
