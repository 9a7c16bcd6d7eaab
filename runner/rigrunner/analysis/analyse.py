"""The one analysis that serves online, stored and batch: pure, without I/O or clock."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import chain
from typing import TYPE_CHECKING

from rigrunner.analysis.document import ALWAYS_SETTINGS
from rigrunner.analysis.named import findings_of
from rigrunner.analysis.revisions import revisions_of
from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.analysis.verdict.decision import decide
from rigrunner.analysis.verdict.evidence import Evidence, as_judged
from rigrunner.analysis.verdict.rule import AppliedRule
from rigrunner.api.analysis_context import AnalysisContext
from rigrunner.api.checks import forbidden
from rigrunner.api.findings import Findings
from rigrunner.api.hooks import AnalysisRecord
from rigrunner.api.instruments import ZEROED
from rigrunner.api.progress import unseen
from rigrunner.api.results import Result
from rigrunner.api.units import si_symbol, unit
from rigrunner.signal.blocks import limits
from rigrunner.signal.rounding import LEAST_PLACES

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api.data import RunData
    from rigrunner.api.progress import Progress
    from rigrunner.procedure import Acceptance, AnalysisRef, Measurand
    from rigrunner.registry import Registry


def analyse(
    run: RunData,
    analyses: Sequence[AnalysisRef],
    *,
    acceptance: Acceptance | None,
    measurand: Measurand | None,
    lookup: Registry,
    progress: Progress = unseen,
    interim: bool = False,
) -> Result:
    """Return the result of a run, with the partner runs that it has.

    `progress` gets the progress of what takes minutes; what it raises ends the analysis. `interim`:
    the run is not over, and what takes minutes is left out. Raises DataError if a recording cannot
    be prepared at all, or a partner run is missing.
    """
    scrutiny = Scrutiny(lookup)
    context = AnalysisContext(
        plugins=scrutiny,
        measurand="" if measurand is None else measurand.name,
        symbol="" if measurand is None else measurand.symbol,
        progress=progress,
        interim=interim,
    )
    parts = findings_of(run, analyses, scrutiny, context=context)
    findings = _joined(parts)
    decision = None
    if acceptance is not None:
        rule = AppliedRule.of(acceptance, scrutiny)
        decision = decide(acceptance, rule, _evidence(parts, findings))
    # The settings that the details of an analysis record; else all, with their defaults.
    recorded = {k: v for details in findings.details for k, v in details.settings().items()}
    others = []
    for ref, part in zip(analyses, parts, strict=True):
        if not any(details.settings() for details in part.details):
            settings = lookup.validated(ref.kind, ref.name, ref.settings)
            text = _as_text(settings.model_dump(exclude_none=True))
            others.append({"name": ref.name, "settings": text})
    result = Result(
        run=run,
        measurand=context.measurand,
        symbol=context.symbol,
        unit=_unit_of(measurand, analyses, lookup),
        decision=decision,
        results=findings.results,
        missing=findings.missing,
        means=findings.means,
        details=findings.details,
        formulas=findings.formulas,
        tables=findings.tables,
        figures=findings.figures,
        sections=findings.sections,
        checks=findings.checks,
        notes=(*(each.sentence for each in findings.missing), *findings.notes),
        settings={**(recorded or ALWAYS_SETTINGS), **({"named": others} if others else {})},
        revisions=revisions_of(analyses, acceptance, lookup),
    )
    if interim or not (result.other_results or result.limits.values):
        return result
    beyond = dict(_beyond_calibration(run))
    noted = (f"{name} exceeded its calibrated range: {text}." for name, text in beyond.items())
    return replace(result, beyond=beyond, notes=(*result.notes, *noted))


def _beyond_calibration(run: RunData) -> Iterator[tuple[str, str]]:
    """Yield each channel with readings beyond its calibrated range, and how far, in words.

    The zero is subtracted from quantities that are zeroed, as in their calibration.
    """
    for instrument in run.instruments.values():
        name, is_zeroed = instrument.channel, instrument.quantity in ZEROED
        names = [name, *(f"{name}.{statistic}" for statistic in ("minimum", "maximum", "mean"))]
        values, unit_of = [], ""
        for row in run.measurements:
            zero = run.zero_of(row, name).value if is_zeroed else 0.0
            values += [row.values[key] - zero for key in names if key in row.values]
            unit_of = row.units.get(name, unit_of)
        for recording in run.recordings:
            if name in recording.channels and recording.samples:
                zero = run.zero_of(recording, name).value if is_zeroed else 0.0
                values += [value - zero for value in limits(recording.channels[name])]
                unit_of = recording.units[name]
        if values and (text := instrument.beyond_range(min(values), max(values), unit_of)):
            yield name, text


def _unit_of(
    measurand: Measurand | None, analyses: Sequence[AnalysisRef], registry: Registry
) -> str:
    """Return the unit of the measurand, '' if it is not known.

    The SI unit of what the analysis gives it for; else as the procedure states it, and that of
    LEAST_PLACES for all of its kind, as documents of result/1 have it.
    """
    for ref in analyses:
        record = registry.record(ref.kind, ref.name)
        if isinstance(record, AnalysisRecord) and record.measurand:
            return si_symbol(record.measurand)
    if measurand is None or measurand.unit is None:
        return ""
    si = si_symbol(unit(measurand.unit).dimension)
    return si if si in LEAST_PLACES else measurand.unit


def _joined(parts: Sequence[Findings]) -> Findings:
    """Return what several analyses found as one, with the checks as judged."""
    names = [field.name for field in fields(Findings)]
    joined = {name: tuple(chain(*(getattr(part, name) for part in parts))) for name in names}
    joined["checks"] = tuple(map(as_judged, joined["checks"]))
    return Findings(**joined)


def _evidence(parts: Sequence[Findings], findings: Findings) -> Evidence:
    """Return all results, each with the reason why nothing can be decided on it.

    An analysis with details states the reason itself; of all others, one failed check forbids all
    decisions, or those on the results that it is about.
    """
    problem = forbidden(
        as_judged(check)
        for part in parts
        if not part.details
        for check in part.checks
        if not check.of
    )
    problems = {result.name: problem for result in findings.results}
    for part in parts:
        if part.details:
            problem = next(filter(None, (details.undecided for details in part.details)), "")
            problem = problem or forbidden(as_judged(each) for each in part.checks if not each.of)
            names = {result.name for result in part.results}
            names.update(*(details.shown_results for details in part.details))
            problems |= dict.fromkeys(names, problem)
    return Evidence(
        results=findings.results,
        missing=findings.missing,
        means=findings.means,
        problems=problems,
        checks=tuple(check for check in findings.checks if check.of),
        details={name: each for each in findings.details for name in each.shown_results},
    )


def _as_text(value: object) -> object:
    """Return settings for JSON, with quantities as they are written."""
    if isinstance(value, dict):
        return {name: _as_text(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_as_text(item) for item in value]
    return value if isinstance(value, bool | int | float | str) else str(value)
