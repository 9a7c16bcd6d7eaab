"""The one analysis that serves online, stored and batch: pure, without I/O or clock."""

from __future__ import annotations

from dataclasses import replace
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

    from rigrunner.analysis.lookup import Lookup
    from rigrunner.api.data import RunData
    from rigrunner.api.progress import Progress
    from rigrunner.procedure import Acceptance, AnalysisRef, Measurand


def analyse(
    run: RunData,
    analyses: Sequence[AnalysisRef],
    *,
    acceptance: Acceptance | None,
    measurand: Measurand | None,
    lookup: Lookup,
    progress: Progress = unseen,
    interim: bool = False,
) -> Result:
    """Return the result of a run, with the partner runs that it has.

    `progress` gets the progress of what takes minutes; what it raises ends the analysis. `interim`:
    the run is not over, and what takes minutes is left out. Raises DataError if a recording cannot
    be prepared at all, or a partner run is missing.
    """
    known = Scrutiny(lookup)
    context = AnalysisContext(
        plugins=known,
        measurand="" if measurand is None else measurand.name,
        symbol="" if measurand is None else measurand.symbol,
        progress=progress,
        interim=interim,
    )
    found = findings_of(run, analyses, known, context=context)
    findings = _joined(found)
    decision = None
    if acceptance is not None:
        rule = AppliedRule.of(acceptance, known)
        decision = decide(acceptance, rule, _evidence(found, findings))
    # What the details of an analysis record of its settings; else all, with their defaults.
    told = [{k: v for one in each.details for k, v in one.settings().items()} for each in found]
    recorded = {key: value for each in told for key, value in each.items()}
    named = []
    for each, own in zip(analyses, told, strict=True):
        if not own:
            settings = known.validated(each.kind, each.name, each.settings)
            text = _as_text(settings.model_dump(exclude_none=True))
            named.append({"name": each.name, "settings": text})
    result = Result(
        run=run,
        measurand=context.measurand,
        symbol=context.symbol,
        unit=_unit_of(measurand, analyses, known),
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
        settings={**(recorded or ALWAYS_SETTINGS), **({"named": named} if named else {})},
        revisions=revisions_of(analyses, acceptance, known),
    )
    if interim or not (result.other_results or result.limits.values):
        return result
    beyond = dict(_beyond_calibration(run))
    noted = (f"{name} exceeded its calibrated range: {text}." for name, text in beyond.items())
    return replace(result, beyond=beyond, notes=(*result.notes, *noted))


def _beyond_calibration(run: RunData) -> Iterator[tuple[str, str]]:
    """Yield each channel with readings beyond its calibrated range, and how far, in words.

    What is zeroed counts less its zero, as it is calibrated.
    """
    for instrument in run.instruments.values():
        name, is_zeroed = instrument.channel, instrument.quantity in ZEROED
        kept = [name, *(f"{name}.{each}" for each in ("minimum", "maximum", "mean"))]
        values, unit_of = [], ""
        for row in run.measurements:
            zero = row.zeros.get(name, run.zero(row.recording, name)) if is_zeroed else 0.0
            values += [row.values[each] - zero for each in kept if each in row.values]
            unit_of = row.units.get(name, unit_of)
        for recording in run.recordings:
            if name in recording.channels and recording.samples:
                zero = run.zero(recording.name, name) if is_zeroed else 0.0
                values += [each - zero for each in limits(recording.channels[name])]
                unit_of = recording.units[name]
        if values and (text := instrument.beyond_range(min(values), max(values), unit_of)):
            yield name, text


def _unit_of(measurand: Measurand | None, analyses: Sequence[AnalysisRef], lookup: Scrutiny) -> str:
    """Return the unit of the measurand, '' if it is not known.

    The SI unit of what the analysis gives it for; else as the procedure states it, and that of
    LEAST_PLACES for all of its kind, as documents of result/1 have it.
    """
    for each in analyses:
        record = lookup.record(each.kind, each.name)
        if isinstance(record, AnalysisRecord) and record.measurand:
            return si_symbol(record.measurand)
    if measurand is None or measurand.unit is None:
        return ""
    si = si_symbol(unit(measurand.unit).dimension)
    return si if si in LEAST_PLACES else measurand.unit


def _joined(found: Sequence[Findings]) -> Findings:
    """Return what several analyses found as one, with the checks as judged."""
    return Findings(
        results=tuple(result for each in found for result in each.results),
        missing=tuple(missing for each in found for missing in each.missing),
        means=tuple(mean for each in found for mean in each.means),
        checks=tuple(as_judged(check) for each in found for check in each.checks),
        notes=tuple(note for each in found for note in each.notes),
        formulas=tuple(formula for each in found for formula in each.formulas),
        tables=tuple(table for each in found for table in each.tables),
        figures=tuple(figure for each in found for figure in each.figures),
        sections=tuple(section for each in found for section in each.sections),
        details=tuple(one for each in found for one in each.details),
    )


def _evidence(found: Sequence[Findings], findings: Findings) -> Evidence:
    """Return all results, each with why nothing can be decided on it.

    An analysis that keeps details says so itself; of all others one failed check forbids all, or
    the results that it is about.
    """
    others = forbidden(
        as_judged(check)
        for each in found
        if not each.details
        for check in each.checks
        if not check.of
    )
    details = {name: one for each in found for one in each.details for name in one.shown_results}
    problems = {each.name: others for each in findings.results}
    for each in found:
        if each.details:
            own = next(filter(None, (one.undecided for one in each.details)), "")
            names = {result.name for result in each.results}.union(
                *(one.shown_results for one in each.details)
            )
            why = own or forbidden(as_judged(check) for check in each.checks if not check.of)
            problems |= dict.fromkeys(names, why)
    return Evidence(
        results=findings.results,
        missing=findings.missing,
        means=findings.means,
        problems=problems,
        checks=tuple(check for check in findings.checks if check.of),
        details=details,
    )


def _as_text(value: object) -> object:
    """Return settings for JSON, with quantities as they are written."""
    if isinstance(value, dict):
        return {name: _as_text(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_as_text(each) for each in value]
    return value if isinstance(value, bool | int | float | str) else str(value)
