"""Which of the named results a limit is held against: each, their mean, or the worst."""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan, nan
from typing import TYPE_CHECKING

from rigrunner.api.analysis import Component
from rigrunner.api.data import Estimate
from rigrunner.api.places import is_at
from rigrunner.signal.coverage import excess_kurtosis
from rigrunner.signal.uncertainty import combine

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api.findings import MeasurementResult
    from rigrunner.procedure import ResultLimit


@dataclass(frozen=True)
class Chosen:
    """What a limit is held against."""

    words: str
    """Which result, and where: 'voltage at load.current = 2 A'."""
    unit: str
    estimate: Estimate | None
    problem: str = ""
    """Why there is none, as a sentence."""


def chosen_by(limit: ResultLimit, results: Sequence[MeasurementResult]) -> Iterator[Chosen]:
    """Yield each value that a limit is held against, at least one."""
    found = [
        each for each in results if each.name == limit.of and is_at(limit.where, each.coordinates)
    ]
    if not found:
        written = limit.max or limit.min
        assert written is not None  # noqa: S101  (a limit has one of them)
        yield Chosen(limit.of, written.unit.symbol, None, f"There is no result '{limit.of}'.")
        return
    symbol = found[0].of.unit
    if limit.mean:
        yield Chosen(f"mean {limit.of}", symbol, mean_of(found))
        return
    if limit.worst:
        limits = limit.limits_in(symbol)
        found = [min(found, key=lambda each: limits.margin(each.estimate.value))]
    for each in found:
        worst = f"worst {limit.of}" if limit.worst else limit.of
        yield Chosen(f"{worst} at {each.place}" if each.place else worst, symbol, each.estimate)


def mean_of(results: Sequence[MeasurementResult]) -> Estimate:
    """Return the mean of results; what they have in common does not average out.

    A line of the budget that is common to all counts with the mean of its contributions, as if it
    were one error in all; others are independent.
    """
    count = len(results)
    value = sum(each.estimate.value for each in results) / count
    lines: list[Component] = []
    for each in results:
        lines += each.components
    if not lines or any(isnan(each.u) for each in lines):
        return Estimate(value, nan, nan, results[0].of.unit)
    common: dict[str, list[Component]] = {}
    combined: list[Component] = []
    for line in lines:
        if line.common:
            common.setdefault(line.name, []).append(line)
        else:
            combined.append(_scaled(line, line.u / count))
    combined += [_scaled(same[0], sum(each.u for each in same) / count) for same in common.values()]
    u, dof = combine(combined)
    kurtosis = excess_kurtosis(((each.u, each.distribution) for each in combined), u)
    return Estimate(value, u, dof, results[0].of.unit, kurtosis)


def _scaled(line: Component, u: float) -> Component:
    return Component(line.name, u, line.dof, line.distribution, line.common)
