"""Which results a limit is held against: each, their mean, or the worst."""

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
class Chosen:
    """What a limit is held against."""

    words: str
    """Which result, and where: 'voltage at load.current = 2 A'; of the headline 'mean', '35 Hz'."""
    unit: str
    estimate: Estimate | None
    uncorrected: Estimate | None = None
    coordinates: Mapping[str, CoordinateValue] = field(default_factory=dict)
    problem: str = ""
    """Why there is none, as a sentence."""
    order: int = 0
    """Where it stands among what the limits of one name are held against."""


def chosen_by(limit: Limit, evidence: Evidence) -> Iterator[Chosen]:
    """Yield each value that a limit is held against, at least one."""
    named = [each for each in evidence.results if each.name == limit.of]
    found = [(number, each) for number, each in enumerate(named) if limit.is_of(each.coordinates)]
    gone = [
        each for each in evidence.missing if each.name == limit.of and limit.is_of(each.coordinates)
    ]
    short = limit.of in evidence.details
    symbol = next((each.of.unit for each in (*named, *gone)), limit.written.unit.symbol)
    mean = MEAN if short else f"mean {limit.of}"
    # A mean over the other places would be another measurand than the one that is limited.
    if limit.mean and gone:
        yield Chosen(mean, symbol, None, problem=gone[0].sentence, order=-1)
        return
    # The mean that an analysis gives is of all its results, not of the places of a limit.
    if limit.mean and len(found) == len(named):
        for each in evidence.means:
            if each.name == limit.of:
                yield Chosen(mean, each.of.unit, each.estimate, each.uncorrected, order=-1)
                return
    if limit.mean and found:
        yield Chosen(mean, symbol, mean_of([each for _, each in found]), order=-1)
        return
    for number, each in found:
        words = f"{limit.of} at {each.place}" if each.place else limit.of
        if short and each.coordinates:
            words = ", ".join(map(str, each.coordinates.values()))
        yield Chosen(words, symbol, each.estimate, each.uncorrected, each.coordinates, order=number)
    for lacking in gone:
        words = f"{limit.of} at {lacking.place}" if lacking.place else limit.of
        yield Chosen(
            words, symbol, None, None, lacking.coordinates, lacking.sentence, order=len(named)
        )
    there = [each.coordinates for each in (*named, *gone)]
    yield from _missing(limit, there, symbol, evidence)


def _missing(
    limit: Limit,
    there: Sequence[Mapping[str, CoordinateValue]],
    symbol: str,
    evidence: Evidence,
) -> Iterator[Chosen]:
    """Yield each place that the limit names and at which there is no result.

    `there` are the places of those with a value, or with a reason why they have none.
    """
    short = limit.of in evidence.details
    for place in each_of(limit.where):
        if any(is_at(place, each) for each in there):
            continue
        where = ", ".join(f"{name} = {value}" for name, value in place.items())
        words = f"{limit.of} at {where}" if where else limit.of
        why = f"There is no result '{limit.of}'."
        if where:
            why = f"There is no result at {where}."
        if short:
            shown = ", ".join(map(str, place.values()))
            words = shown or (MEAN if limit.mean else f"each {limit.each or 'result'}")
            why = f"There is no result at {shown}." if shown else why
        why = evidence.problems.get(limit.of) or why
        yield Chosen(words, symbol, None, problem=why, order=len(there))


def mean_of(results: Sequence[MeasurementResult]) -> Estimate:
    """Return the mean of results; what they have in common does not average out.

    A line of the budget that is common to all counts as one error in all, with the mean of its
    contributions: by their signs where it is known to be the same error, such as a gain, which
    cancels between values of both signs. Other lines are independent.
    """
    count = len(results)
    value = sum(each.estimate.value for each in results) / count
    lines: list[Component] = []
    for each in results:
        lines += each.components
    untold = any(each.estimate.u != 0 and not each.components for each in results)
    if not lines or untold or any(isnan(each.u) for each in lines):
        return Estimate(value, nan, nan, results[0].of.unit)
    common: dict[str, list[Component]] = {}
    combined: list[Component] = []
    for line in lines:
        if line.common:
            common.setdefault(line.name, []).append(line)
        else:
            combined.append(_scaled(line, line.u / count))
    combined += [
        _scaled(same[0], abs(sum(map(_contribution, same))) / count) for same in common.values()
    ]
    u, dof = combine(combined)
    kurtosis = excess_kurtosis(((each.u, each.distribution) for each in combined), u)
    return Estimate(value, u, dof, results[0].of.unit, kurtosis)


def _contribution(line: Component) -> float:
    """Return u with the sign of the sensitivity; without one where that says nothing."""
    return -line.u if line.shared and line.sensitivity < 0 else line.u


def _scaled(line: Component, u: float) -> Component:
    return Component(line.name, u, line.dof, line.distribution, line.common)
