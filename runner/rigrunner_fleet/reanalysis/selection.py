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
class Chosen:
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


def choose(paths: Iterable[Path]) -> list[Chosen]:
    """Return the runs at and below these paths, each once, by their names.

    Raises UsageError for a path that does not exist, a folder without runs, and two runs of one
    name.
    """
    found: dict[str, Chosen] = {}
    for path in paths:
        for each in _at(path):
            known = found.setdefault(each.name, each)
            if known.path != each.path:
                raise UsageError(
                    f"{known.path} and {each.path} would have one result, '{each.name}'",
                    hint="name a folder above both, or analyse them into two folders",
                )
    return [found[name] for name in sorted(found)]


def _at(path: Path) -> Iterator[Chosen]:
    whole = path.resolve()
    if whole.name == RUN_FILE:
        whole = whole.parent
    if whole.is_file():
        yield Chosen(whole.stem, whole)
    elif RunFolder(whole).is_run:
        yield Chosen(whole.name, whole)
    elif whole.is_dir():
        unread: list[Path] = []
        found = run_folders(whole, lambda below, _: unread.append(whole / below))
        runs = [each.folder for each in found]
        if not runs:
            raise UsageError(
                f"there is no run in {path}, nor in any folder below",
                hint=f"not all could be read: {unread[0]}" if unread else "",
            )
        runs += unread  # to be listed as what cannot be read, not left out in silence
        yield from (Chosen(run.relative_to(whole).as_posix(), run) for run in runs)
    else:
        raise UsageError(f"there is no {path}")
