"""The values that a limit applies to: each result, their mean, or the worst."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isnan, nan
from typing import TYPE_CHECKING

from rigrunner.api.analysis import Component
from rigrunner.api.data import Estimate
from rigrunner.api.places import each_of, is_at
from rigrunner.api.verdict import MEAN
from rigrunner.signal.coverage import excess_kurtosis
from rigrunner.signal.uncertainty import combine

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.analysis.verdict.evidence import Evidence
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.findings import MeasurementResult
    from rigrunner.procedure import Limit


@dataclass(frozen=True)
class LimitedValue:
    """A value that a limit applies to."""

    words: str
    """Which result, and where: 'voltage at load.current = 2 A'; of the headline 'mean', '35 Hz'."""
    unit: str
    estimate: Estimate | None
    uncorrected: Estimate | None = None
    coordinates: Mapping[str, CoordinateValue] = field(default_factory=dict)
    problem: str = ""
    """Why there is no estimate, as a sentence."""
    order: int = 0
    """Its position among the values that limits of one name apply to."""


def limited_values(limit: Limit, evidence: Evidence) -> Iterator[LimitedValue]:
    """Yield each value that a limit applies to, at least one."""
    results = [result for result in evidence.results if result.name == limit.of]
    matches = [(i, result) for i, result in enumerate(results) if limit.is_of(result.coordinates)]
    missing = [
        each for each in evidence.missing if each.name == limit.of and limit.is_of(each.coordinates)
    ]
    short = limit.of in evidence.details
    symbol = next((result.of.unit for result in (*results, *missing)), limit.written.unit.symbol)
    mean = MEAN if short else f"mean {limit.of}"
    # A mean over the other places would be another measurand than the one that is limited.
    if limit.mean and missing:
        yield LimitedValue(mean, symbol, None, problem=missing[0].sentence, order=-1)
        return
    # The mean that an analysis gives is of all its results, not of the places of a limit.
    if limit.mean and len(matches) == len(results):
        for own in evidence.means:
            if own.name == limit.of:
                yield LimitedValue(mean, own.of.unit, own.estimate, own.uncorrected, order=-1)
                return
    if limit.mean and matches:
        yield LimitedValue(mean, symbol, mean_of([result for _, result in matches]), order=-1)
        return
    for order, result in matches:
        words, at = limit.of, result.coordinates
        if at:
            words = ", ".join(map(str, at.values())) if short else f"{limit.of} at {result.place}"
        yield LimitedValue(words, symbol, result.estimate, result.uncorrected, at, order=order)
    for gap in missing:
        words = f"{limit.of} at {gap.place}" if gap.place else limit.of
        at, why = gap.coordinates, gap.sentence
        yield LimitedValue(words, symbol, None, None, at, why, order=len(results))
    places = [result.coordinates for result in (*results, *missing)]
    yield from _places_without_result(limit, places, symbol, evidence)


def _places_without_result(
    limit: Limit,
    places: Sequence[Mapping[str, CoordinateValue]],
    symbol: str,
    evidence: Evidence,
) -> Iterator[LimitedValue]:
    """Yield each place that the limit names and at which there is no result.

    `places` are the places of those with a value, or with a reason why they have none.
    """
    short = limit.of in evidence.details
    for place in each_of(limit.where):
        if any(is_at(place, other) for other in places):
            continue
        where = ", ".join(f"{name} = {value}" for name, value in place.items())
        words = f"{limit.of} at {where}" if where else limit.of
        problem = f"There is no result '{limit.of}'."
        if where:
            problem = f"There is no result at {where}."
        if short:
            shown = ", ".join(map(str, place.values()))
            words = shown or (MEAN if limit.mean else f"each {limit.each or 'result'}")
            problem = f"There is no result at {shown}." if shown else problem
        problem = evidence.problems.get(limit.of) or problem
        yield LimitedValue(words, symbol, None, problem=problem, order=len(places))


def mean_of(results: Sequence[MeasurementResult]) -> Estimate:
    """Return the mean of results; what they have in common does not average out.

    A line of the budget that is common to all counts as one error in all, with the mean of its
    contributions: by their signs where it is known to be the same error, such as a gain, which
    cancels between values of both signs. Other lines are independent.
    """
    count = len(results)
    value = sum(result.estimate.value for result in results) / count
    lines: list[Component] = []
    for result in results:
        lines += result.components
    unknown = any(result.estimate.u != 0 and not result.components for result in results)
    if not lines or unknown or any(isnan(line.u) for line in lines):
        return Estimate(value, nan, nan, results[0].of.unit)
    common: dict[str, list[Component]] = {}
    combined: list[Component] = []
    for line in lines:
        if line.common:
            common.setdefault(line.name, []).append(line)
        else:
            combined.append(_scaled(line, line.u / count))
    combined += [
        _scaled(group[0], abs(sum(map(_contribution, group))) / count) for group in common.values()
    ]
    u, dof = combine(combined)
    kurtosis = excess_kurtosis(((line.u, line.distribution) for line in combined), u)
    return Estimate(value, u, dof, results[0].of.unit, kurtosis)


def _contribution(line: Component) -> float:
    """Return u with the sign of the sensitivity, where the error is known to be the same in all."""
    return -line.u if line.shared and line.sensitivity < 0 else line.u


def _scaled(line: Component, u: float) -> Component:
    return Component(line.name, u, line.dof, line.distribution, line.common)
