"""The list of runs in a folder."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError
from rigrunner.runfile import read_info
from rigrunner.workflow.locate import run_names

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.runfile import RunInfo


@dataclass(frozen=True)
class ListedRun:
    """One entry of a folder of runs."""

    name: str
    info: RunInfo | None
    problem: str = ""
    """Why the run cannot be read, where it cannot."""


def list_runs(runs: Path) -> list[ListedRun]:
    """Return all runs of a folder, oldest first; one that cannot be read is listed with why."""
    return [_listed(runs, name) for name in run_names(runs)]


def _listed(runs: Path, name: str) -> ListedRun:
    try:
        return ListedRun(name, read_info(runs / name))
    except RigrunnerError as error:
        return ListedRun(name, None, str(error))
