"""Specimens that a run of the same procedure has tested before."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError, Problem
from rigrunner.api.events import CONCLUDED
from rigrunner.queue.entries import SPECIMEN, looks
from rigrunner.run.locate import run_names
from rigrunner.run.runs import listed_run
from rigrunner.runfile.folder import safe_name

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rigrunner.queue.entries import Draft


def allowed(runs: Path, procedure_id: str, drafts: Sequence[Draft]) -> list[Draft]:
    """Return drafts, with the reason of a test that is repeated only where it is.

    Raises InvalidFileError for each specimen that a run of the procedure has tested, unless the
    draft says why it is tested again.
    """
    names = _names(runs)
    found = [(each, _newest(runs, names, procedure_id, each.specimen)) for each in drafts]
    problems = [
        Problem(
            f"{draft.specimen} has already been tested: run {run}",
            field="again",
            hint="give a reason to test it again",
        )
        for draft, run in found
        if run and not draft.again
    ]
    if problems:
        raise InvalidFileError(problems)
    return [draft if run else draft.model_copy(update={"again": ""}) for draft, run in found]


def tested_by(runs: Path, procedure_id: str, specimen: str) -> str:
    """Return the newest run of a procedure that has tested a specimen; '' for none."""
    return _newest(runs, _names(runs), procedure_id, specimen)


def _names(runs: Path) -> list[tuple[str, str]]:
    """Return the names of runs from the newest, each also in small letters."""
    return [(name, name.casefold()) for name in reversed(run_names(runs))]


def _newest(runs: Path, names: Sequence[tuple[str, str]], procedure_id: str, specimen: str) -> str:
    if not specimen:
        return ""
    # The name of a folder has both, shortened: few files have to be read.
    begin = f"_{safe_name(procedure_id)}_{safe_name(specimen)}".rstrip("_").casefold()
    for name, folded in names:
        if begin in folded and (info := listed_run(runs, name).info) is not None:
            tested = (info.header.procedure_id, looks(info.header.inputs.get(SPECIMEN, "")))
            if info.outcome in CONCLUDED and tested == (procedure_id, looks(specimen)):
                return name
    return ""
