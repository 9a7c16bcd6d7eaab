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
from rigrunner_panel.view.sections import CheckView, Finished, LiveView, ResultView, Value

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
    """Return the result of the recordings so far, or of all, with its limits."""
    limited = [(named, _limits(named, acceptance)) for named in result.results]
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
                name=check.name,
                ok=check.ok,
                text=check.text,
                advice=check.advice,
                effect=effect_words(check),
                consequence=str(check.consequence),
            )
            for check in result.every_check
        ),
        results=tuple(_named_view(named, limits) for named, limits in limited[-MOST_RESULTS:]),
        figures=(*_figures(limited), *result.figures),
    )


def with_live(view: LiveView | None, findings: Findings) -> LiveView:
    """Return the analysis with what a recording in progress shows so far.

    A value of no more readings than the analysis has already is left out.
    """
    view = view or LiveView(recordings=0, final=False, problem="", taken_s=0.0)
    rows = {(row.name, row.place): row for row in view.results}
    for named in findings.results:
        row = _named_view(named, None)
        earlier = rows.pop((row.name, row.place), None)
        if earlier is not None and earlier.readings >= row.readings:
            rows[row.name, row.place] = earlier
            continue
        limits = {} if earlier is None else {"lower": earlier.lower, "upper": earlier.upper}
        rows[row.name, row.place] = row.model_copy(update={"is_ongoing": True, **limits})
    drawn = {(figure.of, figure.title) for figure in findings.figures}
    others = (figure for figure in view.figures if (figure.of, figure.title) not in drawn)
    return view.model_copy(
        update={
            "problem": view.problem or " ".join(findings.notes),
            "results": tuple(rows.values())[-MOST_RESULTS:],
            "figures": (*others, *findings.figures),
        }
    )


def _limits(result: MeasurementResult, acceptance: Acceptance | None) -> Limits | None:
    """Return the first limits on a result that are not on a mean."""
    for limit in acceptance.limits_of(result.name) if acceptance else ():
        if not limit.mean and limit.is_of(result.coordinates):
            with suppress(DataError):  # it follows a coordinate, and has none here
                return limit.limits_at(result.coordinates, result.of.unit)
    return None


def _at(name: str, value: CoordinateValue) -> str:
    """Return a place in words: '2 A', 'final'; a count with what it counts, 'cycles 5'."""
    return str(value) if value.unit or isinstance(value.value, str) else f"{name} {value}"


def _named_view(named: MeasurementResult, limits: Limits | None) -> ResultView:
    return ResultView(
        name=named.name,
        text=named.of.words,
        symbol=named.of.symbol,
        unit=named.of.unit,
        place=", ".join(_at(name, value) for name, value in named.coordinates.items()),
        value=named.estimate.value,
        U=_finite(expanded(named.estimate)),
        readings=named.readings,
        lower=None if limits is None else _finite(limits.lower),
        upper=None if limits is None else _finite(limits.upper),
        uncorrected=None if named.uncorrected is None else named.uncorrected.value,
    )


def _figures(limited: Sequence[tuple[MeasurementResult, Limits | None]]) -> Iterator[Figure]:
    """Yield for each result over a coordinate the figure that shows most: within its limits."""
    for name in dict.fromkeys(named.name for named, _ in limited):
        points = [
            (named, limits, limits is not None and not limits.allow(named.estimate.value))
            for named, limits in limited
            if named.name == name
        ]
        yield from over_coordinate(points)[-1:]


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
        result="" if result is None else _deciding_text(result),
        error="" if error is None else finished.reason if finished.unsafe else str(error),
        hint=getattr(error, "hint", ""),
        sealed=finished.sealed,
        passed_over=finished.passed_over,
    )


def _deciding_text(result: Result) -> str:
    deciding = None if result.decision is None else result.decision.deciding.result
    results = [named for named in result.other_results if named.estimate is deciding]
    if not results and len(result.other_results) == 1:
        results = list(result.other_results)
    if not results:
        return ""
    estimate = results[0].estimate
    shown = with_uncertainty(estimate.value, expanded(estimate))
    return f"{results[0].of.words}: {shown} {estimate.unit}"


def with_uncertainty(value: float, width: float) -> str:
    """Return a value with its expanded uncertainty, '?' where that is not known."""
    return rounding.with_uncertainty(value, width) if isfinite(width) else f"{value:.6g} ± ?"


def _value(estimate: Estimate | None) -> Value | None:
    if estimate is None:
        return None
    return Value(value=estimate.value, U=_finite(expanded(estimate)), unit=estimate.unit)


def _finite(value: float) -> float | None:
    """Return a finite number, or None."""
    return value if isfinite(value) else None
