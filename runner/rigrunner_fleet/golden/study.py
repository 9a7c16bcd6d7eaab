"""The check, for a report on many runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.studies import Excluded, GoldenRun, GoldenStudy, Shift
from rigrunner_fleet.golden.comparing import Standing
from rigrunner_fleet.golden.words import details

if TYPE_CHECKING:
    from rigrunner_fleet.golden.comparing import Compared
    from rigrunner_fleet.golden.overall import AtFrequency, Overall


def golden_study(found: Overall) -> GoldenStudy:
    """Return the check for a report."""
    return GoldenStudy(
        quantity=f"{len(found.moved)} of {len(found.runs)} to be looked at",
        unit="N·m",
        asked={
            "Golden runs": str(len(found.runs)),
            "Tolerance": f"{found.tolerance:g} U",
            **{name: f"{now}, was {then}" for name, then, now in found.made_by},
        },
        excluded=tuple(
            Excluded(each.name, each.problem)
            for each in found.runs
            if each.standing is Standing.NOT_COMPARED
        ),
        tolerance=found.tolerance,
        counts=tuple((str(each), each.moved, count) for each, count in found.counts().items()),
        flips=tuple((then, now, count) for (then, now), count in found.verdict_flips().items()),
        shifts_in_u=tuple(found.shifts_in_u()),
        set_points=tuple(_shift(each) for each in found.by_frequency()),
        runs=tuple(_run(each) for each in found.runs),
    )


def _shift(found: AtFrequency) -> Shift:
    in_u = found.in_u
    return Shift(
        frequency_hz=found.frequency_hz,
        count=found.shift_nm.n,
        mean_nm=found.shift_nm.mean,
        deviation_nm=found.shift_nm.deviation,
        mean_in_u=None if in_u is None else in_u.mean,
        largest_in_u=None if in_u is None else in_u.largest,
    )


def _run(each: Compared) -> GoldenRun:
    return GoldenRun(
        name=each.name,
        standing=str(each.standing),
        moved=each.standing.moved,
        verdict=each.after.verdict,
        lines=tuple(details(each)),
    )
