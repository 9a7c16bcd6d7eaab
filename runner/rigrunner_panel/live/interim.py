"""Interim analysis of a run in progress, from the data stored so far."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rigrunner.analysis.analyse import analyse
from rigrunner.analysis.named import findings_of
from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.api.errors import DataError
from rigrunner.api.hooks import AnalysisRecord
from rigrunner.procedure import parse_procedure
from rigrunner.run.stored import run_data
from rigrunner.runfile import read

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner.analysis.lookup import Lookup
    from rigrunner.api.data import Recording, RunData
    from rigrunner.api.results import Result
    from rigrunner.procedure import Acceptance, AnalysisRef, Measurand
    from rigrunner.registry import Registry
    from rigrunner.runfile import StoredRun


@dataclass(frozen=True)
class LiveAnalysis:
    """The analysis that a run's procedure asks for, without what only the end of the run can give.

    It makes no decision and no validation before the run ends.
    """

    analyses: tuple[AnalysisRef, ...]
    """Those that give the measurand: they must be possible."""
    measurand: Measurand | None
    registry: Registry
    lookup: Lookup
    """The registry, or a wrapper that caches what its analyses prepared."""
    others: tuple[AnalysisRef, ...] = ()
    """Those that name their results: each as soon as it is possible."""
    acceptance: Acceptance | None = None
    """The limits shown with the results."""

    def result(self, run: RunData) -> Result:
        """Return the result of these data; raise DataError.

        An analysis that needs results not yet available is left out.
        """
        found = analyse(
            run,
            self.analyses,
            acceptance=None,
            measurand=self.measurand,
            lookup=self.lookup,
            interim=True,
        )
        others = findings_of(
            run,
            self.others,
            Scrutiny(self.registry),
            known=found.results,
            as_far_as_possible=True,
        )
        named = tuple(result for each in others for result in each.results)
        return replace(found, results=(*found.results, *named))


def live_analysis(stored: StoredRun, registry: Registry) -> LiveAnalysis | None:
    """Return the analysis of a run in progress; None if its procedure asks for none."""
    procedure = parse_procedure(
        stored.header.procedure_text, stored.header.procedure_id, stored=True
    ).model
    if not procedure.analysis:
        return None
    giving = {each.name for each in procedure.analysis if _gives_measurand(each, registry)}
    return LiveAnalysis(
        tuple(each for each in procedure.analysis if each.name in giving),
        procedure.measurand,
        registry,
        registry,
        others=tuple(each for each in procedure.analysis if each.name not in giving),
        acceptance=procedure.acceptance,
    )


def _gives_measurand(analysis: AnalysisRef, registry: Registry) -> bool:
    record = registry.record(analysis.kind, analysis.name)
    return isinstance(record, AnalysisRecord) and bool(record.measurand)


def interim_result(
    folder: Path,
    registry: Registry,
    partners: Mapping[str, StoredRun],
    recording: str = "",
    watched: Recording | None = None,
) -> tuple[Result, Acceptance | None] | None:
    """Return the result of the recordings so far, and its limits; None if there is no result yet.

    `recording` names the recording in progress: its whole swings are included once the analysis
    accepts their number. `watched` is analysed in place of all recordings. Raises DataError.
    """
    stored = read(folder)
    analysis = live_analysis(stored, registry)
    if analysis is None:
        return None
    finished = run_data(replace(stored, partners=partners))
    if watched is not None:
        return analysis.result(replace(finished, recordings=(watched,))), analysis.acceptance
    unfinished = [each for each in stored.incomplete if each.name == recording][-1:]
    if unfinished:
        try:
            with_it = replace(finished, recordings=(*finished.recordings, *unfinished))
            return analysis.result(with_it), analysis.acceptance
        except DataError:  # too short as yet
            pass
    if not (finished.recordings or finished.measurements):
        return None
    return analysis.result(finished), analysis.acceptance
