"""The main number of a run, unless a package of its analysis gives one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner_reports.numbers import stated
from rigrunner_reports.section import Headline, Section

if TYPE_CHECKING:
    from rigrunner.api.results import Result


def headline(result: Result) -> Headline:
    """Return the deciding named result; or what was measured or recorded."""
    if result.other_results:
        return _of_result(result)
    return _of_limits(result) if result.limits.values else _of_recordings(result)


def _of_result(result: Result) -> Headline:
    """Return the result on which the verdict rests, or else the first one."""
    deciding = None if result.decision is None else result.decision.deciding
    named = next(
        (r for r in result.other_results if deciding is not None and r.estimate is deciding.result),
        result.other_results[0],
    )
    estimate, place, several = named.estimate, named.place, len(result.other_results) > 1
    label = named.of.title
    if deciding is not None and deciding.result is not None:
        estimate = deciding.result
        if estimate is not named.estimate:  # a mean of several
            label, place = deciding.of[:1].upper() + deciding.of[1:], ""
    shown = stated(estimate)
    where = f"At {place}. " if place else ""
    others = f" One of {len(result.other_results)} results; all are below." if several else ""
    return Headline(
        label=label,
        symbol=named.of.symbol,
        value=shown.value,
        interval=f"± {shown.expanded}",
        unit=shown.unit,
        detail=f"{where}U for 95 %, k = {shown.factor}.{others}",
    )


def _of_recordings(result: Result) -> Headline:
    """Return what was recorded, for a run without results and limits."""
    recordings, rows = len(result.run.recordings), len(result.run.measurements)
    value = f"{recordings}" if recordings else f"{rows}"
    return Headline(
        label="Recordings" if recordings else "Rows of measured values",
        symbol="",
        value=value,
        interval="",
        unit="",
        detail="The procedure asks for no analysis and has no limits: this is what was recorded.",
    )


def _of_limits(result: Result) -> Headline:
    """Return how many measured values are within their limits, for a run without an analysis."""
    missed, judged = len(result.limits.missed), len(result.limits.values)
    return Headline(
        label="Measured values out of limits" if missed else "Measured values within limits",
        symbol="",
        value=f"{missed or judged} of {judged}",
        interval="",
        unit="",
        detail="Every one of them is in the table below.",
    )


SECTIONS = (Section("result", "Result", 0, lambda _, page: page, unbroken=True),)
