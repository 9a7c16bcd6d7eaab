"""Select the runs to analyse again, and the name of each result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError
from rigrunner.run.locate import RUN_FILE
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.scan import run_folders

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path


@dataclass(frozen=True)
class SelectedRun:
    """A run, and the name of its result: its path from the folder that was named."""

    name: str
    path: Path
    """The run's folder, or a single file; absolute, as other machines see it."""

    @property
    def stamp(self) -> str:
        """Changes with the recorded data; empty for a run that is not sealed."""
        file = self.path / RUN_FILE if self.path.is_dir() else self.path
        try:
            facts = file.stat()
        except OSError:
            return ""
        return f"{facts.st_size} {facts.st_mtime_ns}"


def select_runs(paths: Iterable[Path]) -> list[SelectedRun]:
    """Return the runs at and below these paths, each once, by their names.

    Raises UsageError for a path that does not exist, a folder without runs, and two runs of one
    name.
    """
    runs: dict[str, SelectedRun] = {}
    for path in paths:
        for run in _at(path):
            first = runs.setdefault(run.name, run)
            if first.path != run.path:
                raise UsageError(
                    f"{first.path} and {run.path} would have one result, '{run.name}'",
                    hint="name a folder above both, or analyse them into two folders",
                )
    return [runs[name] for name in sorted(runs)]


def _at(path: Path) -> Iterator[SelectedRun]:
    absolute = path.resolve()
    if absolute.name == RUN_FILE:
        absolute = absolute.parent
    if absolute.is_file():
        yield SelectedRun(absolute.stem, absolute)
    elif RunFolder(absolute).is_run:
        yield SelectedRun(absolute.name, absolute)
    elif absolute.is_dir():
        unreadable: list[Path] = []
        folders = run_folders(absolute, lambda below, _: unreadable.append(absolute / below))
        runs = [found_run.folder for found_run in folders]
        if not runs:
            raise UsageError(
                f"there is no run in {path}, nor in any folder below",
                hint=f"not all could be read: {unreadable[0]}" if unreadable else "",
            )
        runs += unreadable  # so that they are listed as unreadable
        yield from (SelectedRun(run.relative_to(absolute).as_posix(), run) for run in runs)
    else:
        raise UsageError(f"there is no {path}")
