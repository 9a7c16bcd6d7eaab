"""The list of runs in a folder."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError
from rigrunner.api.events import Outcome
from rigrunner.run.locate import run_names
from rigrunner.runfile import NEVER_ENDED, is_in_progress, read_info

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.runfile import RunInfo


@dataclass(frozen=True)
class ListedRun:
    """One entry of a folder of runs."""

    name: str
    info: RunInfo | None
    problem: str = ""
    """Why the run cannot be read; '' if it can."""
    is_in_progress: bool = False
    """Whether a process is writing to it."""
    waits: bool = False
    """Whether only the partner run after it is missing."""

    @property
    def state(self) -> str:
        """The outcome of the run, or why it has none yet, as text."""
        if self.info is None:
            return "unreadable"
        if self.is_in_progress:
            return "running"
        if self.info.sealed:
            return self.info.outcome
        if self.info.reason == NEVER_ENDED:
            return "interrupted"
        if self.waits:
            return f"{self.info.outcome}, waits for a run after it"
        return f"{self.info.outcome}, not sealed"

    @property
    def is_interrupted(self) -> bool:
        """Whether it was interrupted, and can be resumed or recovered."""
        return self.info is not None and not self.info.sealed and not self.is_in_progress


def list_runs(runs: Path) -> list[ListedRun]:
    """Return all runs of a folder, oldest first; unreadable ones with their problem."""
    return [listed_run(runs, name) for name in run_names(runs)]


def listed_run(runs: Path, name: str) -> ListedRun:
    """Return one run of a folder of runs."""
    try:
        in_progress = is_in_progress(runs / name)
        info = read_info(runs / name)
        is_open = not info.sealed and info.outcome == Outcome.COMPLETED
        # A partner run that does not exist yet has no path.
        waits = is_open and not all(info.header.files.values())
        return ListedRun(name, info, is_in_progress=in_progress, waits=waits)
    except RigrunnerError as error:
        return ListedRun(name, None, str(error))
