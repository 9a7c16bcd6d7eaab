"""The result of an analysis, for the screen: the numbers that the report has."""

from __future__ import annotations

from contextlib import suppress
from math import isfinite
from typing import TYPE_CHECKING

from rigrunner.api.checks import effect_words
from rigrunner.api.errors import DataError
from rigrunner.api.verdict import Verdict, worst
from rigrunner.signal import rounding
from rigrunner.signal.coverage import expanded
from rigrunner.signal.result_figures import over_coordinate
from rigrunner_panel.view.sections import (
    CheckView,
    Finished,
    LiveView,
    ResultView,
    Value,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.data import Estimate
    from rigrunner.api.figures import Figure
    from rigrunner.api.findings import Findings, MeasurementResult
    from rigrunner.api.results import Result
    from rigrunner.api.verdict import Limits
    from rigrunner.procedure import Acceptance
    from rigrunner.run.finish import FinishedRun

MOST_RESULTS = 200
"""Of named results, the latest are sent to the screen."""


def live_view(
    result: Result, *, final: bool, taken_s: float = 0.0, acceptance: Acceptance | None = None
) -> LiveView:
    """Return the result of the recordings so far, or of all, with what it may be."""
    limited = [(each, _limits(each, acceptance)) for each in result.results]
    # On what was measured so far: all within limits is no verdict yet.
    missed = Verdict.FAIL if result.limits.missed else None
    verdict = worst((missed, result.decision.verdict if result.decision else None))
    return LiveView(
        recordings=len(result.run.recordings),
        final=final,
        problem=" ".join(result.notes),
        taken_s=taken_s,
        verdict=str(verdict or ""),
        headline=_value(result.headline),
        checks=tuple(
            CheckView(
                name=each.name,
                ok=each.ok,
                text=each.text,
                advice=each.advice,
                effect=effect_words(each),
                consequence=str(each.consequence),
            )
            for each in result.every_check
        ),
        results=tuple(_named_view(each, limits) for each, limits in limited[-MOST_RESULTS:]),
        figures=(*_figures(limited), *result.figures),
    )


def with_live(view: LiveView | None, found: Findings) -> LiveView:
    """Return the analysis with what a recording in progress shows so far.

    A value of no more readings than the analysis has already is left out.
    """
    view = view or LiveView(recordings=0, final=False, problem="", taken_s=0.0)
    rows = {(each.name, each.place): each for each in view.results}
    for each in found.results:
        now = _named_view(each, None)
        known = rows.pop((now.name, now.place), None)
        if known is not None and known.readings >= now.readings:
            rows[now.name, now.place] = known
            continue
        limits = {} if known is None else {"lower": known.lower, "upper": known.upper}
        rows[now.name, now.place] = now.model_copy(update={"is_ongoing": True, **limits})
    drawn = {(each.of, each.title) for each in found.figures}
    others = (each for each in view.figures if (each.of, each.title) not in drawn)
    return view.model_copy(
        update={
            "problem": view.problem or " ".join(found.notes),
            "results": tuple(rows.values())[-MOST_RESULTS:],
            "figures": (*others, *found.figures),
        }
    )


def _limits(result: MeasurementResult, acceptance: Acceptance | None) -> Limits | None:
    """Return what a result may be by the first limit on it, which is none of a mean."""
    for limit in acceptance.limits_of(result.name) if acceptance else ():
        if not limit.mean and limit.is_of(result.coordinates):
            with suppress(DataError):  # it follows a coordinate, and has none here
                return limit.limits_at(result.coordinates, result.of.unit)
    return None


def _at(name: str, value: CoordinateValue) -> str:
    """Return a place in words: '2 A', 'final'; a count with what it counts, 'cycles 5'."""
    return str(value) if value.unit or isinstance(value.value, str) else f"{name} {value}"


def _named_view(found: MeasurementResult, limits: Limits | None) -> ResultView:
    return ResultView(
        name=found.name,
        text=found.of.words,
        symbol=found.of.symbol,
        unit=found.of.unit,
        place=", ".join(_at(name, value) for name, value in found.coordinates.items()),
        value=found.estimate.value,
        U=_known(expanded(found.estimate)),
        readings=found.readings,
        lower=None if limits is None else _known(limits.lower),
        upper=None if limits is None else _known(limits.upper),
        uncorrected=None if found.uncorrected is None else found.uncorrected.value,
    )


def _figures(limited: Sequence[tuple[MeasurementResult, Limits | None]]) -> Iterator[Figure]:
    """Yield for each result over a coordinate the figure that shows most: within its limits."""
    for name in dict.fromkeys(each.name for each, _ in limited):
        own = [
            (each, at, at is not None and not at.allow(each.estimate.value))
            for each, at in limited
            if each.name == name
        ]
        yield from over_coordinate(own)[-1:]


def finished_view(finished: FinishedRun) -> Finished:
    """Return how a run ended."""
    result, error = finished.result, finished.error
    return Finished(
        run=finished.folder.name,
        folder=str(finished.folder),
        outcome=finished.outcome,
        reason=finished.reason,
        verdict=str((result and result.verdict) or ""),
        headline=None if result is None else _value(result.headline),
        measurand="" if result is None else result.measurand,
        result="" if result is None else _named(result),
        error="" if error is None else finished.reason if finished.unsafe else str(error),
        hint=getattr(error, "hint", ""),
        sealed=finished.sealed,
        passed_over=finished.passed_over,
    )


def _named(result: Result) -> str:
    deciding = None if result.decision is None else result.decision.deciding.result
    found = [each for each in result.other_results if each.estimate is deciding]
    if not found and len(result.other_results) == 1:
        found = list(result.other_results)
    if not found:
        return ""
    estimate = found[0].estimate
    shown = with_uncertainty(estimate.value, expanded(estimate))
    return f"{found[0].of.words}: {shown} {estimate.unit}"


def with_uncertainty(value: float, width: float) -> str:
    """Return a value with its expanded uncertainty, '?' where that is not known."""
    return rounding.with_uncertainty(value, width) if isfinite(width) else f"{value:.6g} ± ?"


def _value(estimate: Estimate | None) -> Value | None:
    if estimate is None:
        return None
    return Value(value=estimate.value, U=_known(expanded(estimate)), unit=estimate.unit)


def _known(value: float) -> float | None:
    """Return a number that a screen can show; what the data do not tell is not a number."""
    return value if isfinite(value) else None
