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
                available = "there is 1 value" if count == 1 else f"there are {count} values"
                raise DataError(
                    f"{available}, and the baseline is the first {self.first}",
                    hint="wait for more, or name a shorter baseline",
                )
            return [index < self.first for index in range(len(observed))]
        return [
            (self.since is None or value.started_utc >= self.since)
            and (self.until is None or value.started_utc < self.until)
            for value in observed
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
        texts = {rule.name: rule.text for rule in RULES[self.rules]}
        return {**texts, MOVING_RANGE: _TEXTS[MOVING_RANGE]}


def control_chart(name: str, observed: Sequence[Observed], charting: Charting) -> TrendSeries:
    """Return the chart of a group, oldest first; the limits are of its baseline alone.

    Raises DataError if the baseline is too short, or its values are all equal.
    """
    in_baseline = charting.baseline.of(observed)
    values = [value.value for value in observed]
    base = [value for value, of_base in zip(values, in_baseline, strict=True) if of_base]
    limits = individuals(base)
    # An EWMA of weight 1 is the values, between three sigma.
    weight = charting.weight if charting.chart == "ewma" else 1.0
    shown = ewma(values, limits.individuals.centre, limits.individuals.sigma, weight=weight)
    ranges = [None, *(float(difference) for difference in moving_ranges(values))]
    rules = _rules(values, limits, shown, charting)
    points = tuple(
        ChartPoint(
            value,
            of_base,
            float(shown.values[index]),
            float(shown.lower[index]),
            float(shown.upper[index]),
            ranges[index],
            tuple(rules[index]),
        )
        for index, (value, of_base) in enumerate(zip(observed, in_baseline, strict=True))
    )
    series = TrendSeries(name, points, limits.individuals, limits.moving_range, lag_one(base))
    return replace(series, warnings=tuple(_warnings(series, len(base))))


def _rules(
    values: Sequence[float], limits: Individuals, shown: Ewma, charting: Charting
) -> list[list[str]]:
    if charting.chart == "ewma":
        outside = (shown.values > shown.upper) | (shown.values < shown.lower)
        return [[EWMA] if is_outside else [] for is_outside in outside]
    names: list[list[str]] = [[] for _ in values]
    chart = limits.individuals
    for signal in signals(values, chart.centre, chart.sigma, charting.rules):
        names[signal.index].append(signal.rule.name)
    for index in np.flatnonzero(moving_ranges(values) > limits.moving_range.upper):
        # A moving range is shown at the later one of its two values.
        names[int(index) + 1].append(MOVING_RANGE)
    return names


def _warnings(series: TrendSeries, count: int) -> list[str]:
    warnings = []
    if count < _ADVISED:
        warnings.append(f"the limits rest on {count} values: {_ADVISED} to 25 are advised")
    unstable = sum(1 for point in series.points if point.baseline and point.rules)
    if unstable:
        warnings.append(
            f"the baseline itself meets a rule at {unstable} of {count} values: find the cause,"
            " and choose another baseline if the rig was faulty"
        )
    if abs(series.lag_one) > 2.0 / sqrt(count):
        warnings.append(
            f"neighbours in the baseline are correlated, by {series.lag_one:.2f}: the rate of"
            " false alarms differs from that of the rules"
        )
    expanded = [point.observed.expanded for point in series.points if point.observed.expanded]
    if expanded and 3.0 * series.individuals.sigma < median(expanded):
        warnings.append(
            "the limits are narrower than the expanded uncertainty of a value: an alarm may be"
            " real and still smaller than the uncertainty of a single result"
        )
    return warnings
