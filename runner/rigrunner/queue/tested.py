"""Specimens that a run of the same procedure has tested before."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.events import CONCLUDED
from rigrunner.api.results import REPLAYED
from rigrunner.queue.entries import SPECIMEN, looks
from rigrunner.run.locate import run_names
from rigrunner.run.runs import listed_run
from rigrunner.runfile.folder import safe_name

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path


def tested_before(runs: Path, procedure_id: str, specimens: Iterable[str]) -> dict[str, str]:
    """Return a sentence with the newest run, for each specimen that a procedure has tested."""
    names = [(name, name.casefold()) for name in reversed(run_names(runs))]
    newest = {each: _newest(runs, names, procedure_id, each) for each in specimens if each}
    return {
        specimen: f"{specimen} has already been tested: run {run}"
        for specimen, run in newest.items()
        if run
    }


def _newest(runs: Path, names: Sequence[tuple[str, str]], procedure_id: str, specimen: str) -> str:
    """Return the first of names, from the newest and each also in small letters; '' for none."""
    # The name of a folder has both, shortened: few files have to be read.
    folder_part = f"_{safe_name(procedure_id)}_{safe_name(specimen)}".rstrip("_").casefold()
    for name, folded in names:
        if folder_part in folded and (info := listed_run(runs, name).info) is not None:
            test = (info.header.procedure_id, looks(info.header.inputs.get(SPECIMEN, "")))
            is_test = info.outcome in CONCLUDED and REPLAYED not in info.header.provenance
            if is_test and test == (procedure_id, looks(specimen)):
                return name
    return ""
