"""The analysis of a run that goes on: the stored analysis, fed with what is on the disk by now."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.analysis.analyse import analyse
from rigrunner.api.errors import DataError
from rigrunner.procedure import parse_procedure
from rigrunner.runfile import read
from rigrunner.workflow.stored import NO_ANALYSIS, run_data

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.api.data import Recording, RunData
    from rigrunner.api.results import Result
    from rigrunner.registry import Registry
    from rigrunner.runfile import StoredRun


def result_so_far(
    folder: Path,
    registry: Registry,
    no_load: StoredRun | None,
    recording: str = "",
    watched: Recording | None = None,
) -> Result | None:
    """Return the result of the recordings so far; None where there is none yet.

    `recording` names the one that goes on: it takes part with its whole swings, once the analysis
    accepts as few. `watched` is analysed in the place of all of them. Nothing is decided, and no
    validation made, before the run is over. Raises DataError.
    """
    stored = read(folder)
    procedure = parse_procedure(stored.header.procedure_text, stored.header.procedure_id).model
    if procedure.analysis == NO_ANALYSIS:
        return None
    spec = procedure.analysis.model_copy(update={"validate_": None})

    def result(run: RunData) -> Result:
        return analyse(
            run,
            None if no_load is None else run_data(no_load),
            spec,
            acceptance=None,
            measurand=procedure.measurand,
            lookup=registry,
        )

    finished = run_data(stored)
    if watched is not None:
        return result(replace(finished, recordings=(watched,)))
    going_on = [each for each in stored.incomplete if each.name == recording][-1:]
    if going_on:
        try:
            return result(replace(finished, recordings=(*finished.recordings, *going_on)))
        except DataError:  # too short as yet
            pass
    if not (finished.recordings or finished.measurements):
        return None
    return result(finished)
