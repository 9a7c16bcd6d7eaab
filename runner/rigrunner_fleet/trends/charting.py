"""Make the control chart of the values of many runs, with its rules and reservations."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import DataError
from rigrunner.api.studies import ChartPoint, TrendSeries
from rigrunner_fleet.trends.charts import Ewma, ewma, individuals, lag_one, moving_ranges
from rigrunner_fleet.trends.rules import RULES, signals

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from datetime import datetime

    from rigrunner.api.studies import Observed
    from rigrunner_fleet.trends.charts import Individuals

MOVING_RANGE = "moving range"
EWMA = "EWMA"
_ADVISED = 20
"""Baseline values from which limits are not reported as uncertain (ASTM E2587)."""
_TEXTS = {
    MOVING_RANGE: "a difference of neighbours beyond its upper limit",
    EWMA: "the weighted mean beyond its limits",
}


@dataclass(frozen=True)
class Baseline:
    """The values that the limits are made of: the first ones, or those within a time span."""

    first: int | None = _ADVISED
    since: datetime | None = None
    until: datetime | None = None
    """The end of the span, exclusive."""

    def of(self, observed: Sequence[Observed]) -> list[bool]:
        """Return which values, oldest first, belong to it; raise DataError if there are too few."""
        if self.first is not None:
            if len(observed) < self.first:
                count = len(observed)
                told = "there is 1 value" if count == 1 else f"there are {count} values"
                raise DataError(
                    f"{told}, and the baseline is the first {self.first}",
                    hint="wait for more, or name a shorter baseline",
                )
            return [place < self.first for place in range(len(observed))]
        return [
            (self.since is None or each.started_utc >= self.since)
            and (self.until is None or each.started_utc < self.until)
            for each in observed
        ]


@dataclass(frozen=True)
class Charting:
    """The kind of chart: 'i-mr' or 'ewma', the set of rules, the baseline, an EWMA's weight."""

    chart: str = "i-mr"
    rules: str = "nelson"
    baseline: Baseline = Baseline()
    weight: float = 0.2

    def rule_texts(self) -> Mapping[str, str]:
        """Return the applied rules as text."""
        if self.chart == "ewma":
            return {EWMA: _TEXTS[EWMA]}
        named = {each.name: each.text for each in RULES[self.rules]}
        return {**named, MOVING_RANGE: _TEXTS[MOVING_RANGE]}


def charted(name: str, observed: Sequence[Observed], how: Charting) -> TrendSeries:
    """Return the chart of a group, oldest first; the limits are of its baseline alone.

    Raises DataError if the baseline is too short, or its values are all equal.
    """
    taken = how.baseline.of(observed)
    values = [each.value for each in observed]
    base = [value for value, of_base in zip(values, taken, strict=True) if of_base]
    limits = individuals(base)
    # An EWMA of weight 1 is the values, between three sigma.
    weight = how.weight if how.chart == "ewma" else 1.0
    shown = ewma(values, limits.individuals.centre, limits.individuals.sigma, weight=weight)
    ranges = [None, *(float(each) for each in moving_ranges(values))]
    rules = _rules(values, limits, shown, how)
    points = tuple(
        ChartPoint(
            each,
            of_base,
            float(shown.values[place]),
            float(shown.lower[place]),
            float(shown.upper[place]),
            ranges[place],
            tuple(rules[place]),
        )
        for place, (each, of_base) in enumerate(zip(observed, taken, strict=True))
    )
    series = TrendSeries(name, points, limits.individuals, limits.moving_range, lag_one(base))
    return replace(series, warnings=tuple(_warnings(series, len(base))))


def _rules(
    values: Sequence[float], limits: Individuals, shown: Ewma, how: Charting
) -> list[list[str]]:
    if how.chart == "ewma":
        outside = (shown.values > shown.upper) | (shown.values < shown.lower)
        return [[EWMA] if each else [] for each in outside]
    found: list[list[str]] = [[] for _ in values]
    of_values = limits.individuals
    for signal in signals(values, of_values.centre, of_values.sigma, how.rules):
        found[signal.index].append(signal.rule.name)
    for place in np.flatnonzero(moving_ranges(values) > limits.moving_range.upper):
        # A moving range is shown at the later one of its two values.
        found[int(place) + 1].append(MOVING_RANGE)
    return found


def _warnings(series: TrendSeries, count: int) -> list[str]:
    found = []
    if count < _ADVISED:
        found.append(f"the limits rest on {count} values: {_ADVISED} to 25 are advised")
    unstable = sum(1 for each in series.points if each.baseline and each.rules)
    if unstable:
        found.append(
            f"the baseline itself meets a rule at {unstable} of {count} values: find the cause,"
            " and choose another baseline if the rig was faulty"
        )
    if abs(series.lag_one) > 2.0 / sqrt(count):
        found.append(
            f"neighbours in the baseline are correlated, by {series.lag_one:.2f}: the rate of"
            " false alarms differs from that of the rules"
        )
    stated = [each.observed.expanded for each in series.points if each.observed.expanded]
    if stated and 3.0 * series.individuals.sigma < median(stated):
        found.append(
            "the limits are narrower than the expanded uncertainty of a value: an alarm may be"
            " real and still smaller than the uncertainty of a single result"
        )
    return found
