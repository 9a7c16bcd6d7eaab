"""Interim analysis of a run in progress, from the data stored so far."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.analysis.analyse import analyse
from rigrunner.analysis.named import findings_of
from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.api.hooks import AnalysisRecord
from rigrunner.procedure import parse_procedure
from rigrunner.run.stored import run_data
from rigrunner.runfile import read

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner.api.data import Recording
    from rigrunner.api.results import Result
    from rigrunner.procedure import Acceptance, AnalysisRef
    from rigrunner.registry import Registry
    from rigrunner.runfile import StoredRun


def interim_result(
    folder: Path,
    registry: Registry,
    partners: Mapping[str, StoredRun],
    watched: Recording | None = None,
) -> tuple[Result, Acceptance | None] | None:
    """Return the result of the finished recordings, and its limits; None if there is none yet.

    `watched` is analysed in place of all recordings. It makes no decision and no validation, and
    an analysis that needs results not yet available is left out. The analysis that gives the
    measurand must be possible. Raises DataError.
    """
    stored = read(folder)
    procedure = parse_procedure(
        stored.header.procedure_text, stored.header.procedure_id, stored=True
    ).model
    run = run_data(replace(stored, partners=partners))
    if watched is not None:
        run = replace(run, recordings=(watched,))
    if not procedure.analysis or not (run.recordings or run.measurements):
        return None
    for_measurand = [ref for ref in procedure.analysis if _gives_measurand(ref, registry)]
    result = analyse(
        run,
        for_measurand,
        acceptance=None,
        measurand=procedure.measurand,
        lookup=registry,
        interim=True,
    )
    others = findings_of(
        run,
        [ref for ref in procedure.analysis if ref not in for_measurand],
        Scrutiny(registry),
        known=result.results,
        missing=result.missing,
        as_far_as_possible=True,
    )
    return replace(
        result,
        results=(*result.results, *(result for findings in others for result in findings.results)),
        figures=(*result.figures, *(figure for findings in others for figure in findings.figures)),
    ), procedure.acceptance


def _gives_measurand(analysis: AnalysisRef, registry: Registry) -> bool:
    record = registry.record(analysis.kind, analysis.name)
    return isinstance(record, AnalysisRecord) and bool(record.measurand)
