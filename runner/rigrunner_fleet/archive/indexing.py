"""Update an archive from the run files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import islice
from threading import Event
from typing import TYPE_CHECKING

from sqlalchemy import select

from rigrunner.api.errors import UsageError
from rigrunner.jobs import InProcess
from rigrunner.runfile.scan import run_folders, storable
from rigrunner_fleet.archive.documents import LONGEST_KEY
from rigrunner_fleet.archive.run_facts import RunFacts, read_facts
from rigrunner_fleet.archive.schema import ROOTS
from rigrunner_fleet.archive.storing import (
    forget_moved,
    known_runs,
    mark_missing,
    root_folder,
    root_of,
    store,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    from rigrunner.jobs import Done, Workers
    from rigrunner.runfile.scan import FoundRun
    from rigrunner_fleet.archive.database import Database
    from rigrunner_fleet.archive.storing import Known

    Progress = Callable[[int, int], None]

HERE = InProcess()
_BATCH = 64
"""Runs that are read before a transaction writes them, so that no process waits long."""


def no_progress(done: int, of: int) -> None:
    """Report no progress."""


@dataclass(frozen=True)
class Indexed:
    """The outcome of indexing a folder."""

    folder: Path
    runs: int
    """The number of run folders."""
    new: int
    changed: int
    unreadable: tuple[tuple[str, str], ...]
    """Path and problem of each run that cannot be read."""
    missing: tuple[str, ...]
    """The paths of runs in the archive whose files are gone."""


def index(
    database: Database,
    folders: Sequence[Path],
    *,
    again: bool = False,
    workers: Workers = HERE,
    progress: Progress = no_progress,
) -> list[Indexed]:
    """Update an archive from these folders; with `again`, read unchanged runs too.

    Several programs may do so at once. The files are read by the `workers`; in worker processes a
    run that crashes the HDF5 library is only one more unreadable run. `progress` gets the number of
    runs read, and of all. Raises UsageError for a path that is no folder of runs, and DataError if
    the database fails.
    """
    for folder in folders:
        _check(folder)
    database.make()
    work = [_work_in(database, folder, again=again) for folder in folders]
    count = _Count(progress, sum(len(folder.stale) for folder in work))
    return [_update(database, folder, workers, count) for folder in work]


def rebuild(
    database: Database,
    folders: Sequence[Path],
    *,
    workers: Workers = HERE,
    progress: Progress = no_progress,
) -> list[Indexed]:
    """Rebuild an archive from these folders, or from those that it knows.

    Runs whose files are gone are removed. Raises as `index` does.
    """
    folders = folders or known_folders(database)
    if not folders:
        raise UsageError("the archive has no folder", hint="name the folders of runs")
    for folder in folders:
        _check(folder)
    database.empty()
    return index(database, folders, workers=workers, progress=progress)


def known_folders(database: Database) -> list[Path]:
    """Return the folders of an archive."""
    with database.reading() as connection:
        paths = list(connection.scalars(select(ROOTS.c.path).order_by(ROOTS.c.id)))
    return [root_folder(database.file, path) for path in paths]


def _check(folder: Path) -> None:
    if not folder.is_dir():
        raise UsageError(f"there is no folder {folder}")
    if any((folder / name).exists() for name in ("run.h5", "journal")):
        raise UsageError(f"{folder} is a run", hint="name the folder that holds it")


@dataclass(frozen=True)
class _Work:
    """The runs to read in a folder."""

    folder: Path
    root: int
    known_rows: Mapping[str, Known]
    runs: Mapping[str, FoundRun]
    stale: Sequence[FoundRun]
    skipped: Sequence[tuple[str, str]]
    """Path and problem of each skipped run: unreadable folders, paths that are too long."""


def _work_in(database: Database, folder: Path, *, again: bool) -> _Work:
    with database.writing() as connection:
        root = root_of(connection, database.file, folder)
        known_rows = known_runs(connection, root)
    skipped: list[tuple[str, str]] = []
    found_runs = list(run_folders(folder, lambda *entry: skipped.append(entry)))
    runs = {run.path: run for run in found_runs if len(run.path) <= LONGEST_KEY}
    long = "its path is too long for an archive"
    skipped += [(run.path, long) for run in found_runs if run.path not in runs]
    stale = []
    for run in runs.values():
        row = known_rows.get(run.path)
        is_read = row is not None and not row.missing and run.stamp and row.stamp == run.stamp
        if again or not is_read:
            stale.append(run)
    return _Work(folder, root, known_rows, runs, stale, skipped)


def _update(database: Database, work: _Work, workers: Workers, count: _Count) -> Indexed:
    unreadable = [*work.skipped]
    for facts in _batches(map(_facts, workers.outcomes(read_facts, work.stale, Event()))):
        with database.writing() as connection:
            store(connection, work.root, facts)
        unreadable += [(run.found_run.path, run.problem) for run in facts if run.problem]
        count.add(len(facts))
    gone = [row.id for path, row in work.known_rows.items() if path not in work.runs]
    with database.writing() as connection:
        mark_missing(connection, gone)
        forget_moved(connection, work.root)
        missing = [path for path, row in known_runs(connection, work.root).items() if row.missing]
    return Indexed(
        folder=work.folder,
        runs=len(work.runs),
        new=sum(run.path not in work.known_rows for run in work.stale),
        changed=sum(run.path in work.known_rows for run in work.stale),
        unreadable=tuple(sorted(unreadable)),
        missing=tuple(sorted(missing)),
    )


class _Count:
    """Reports the number of runs read in all folders, if there are any to read."""

    def __init__(self, progress: Progress, total: int) -> None:
        self._progress, self._total, self._done = progress, total, 0
        self.add(0)

    def add(self, count: int) -> None:
        self._done += count
        if self._total:
            self._progress(self._done, self._total)


def _facts(done: Done[FoundRun, RunFacts]) -> RunFacts:
    """Return the facts from a worker. If the worker died, the run is read again next time.

    The cause of the death may be something else, such as a lack of memory.
    """
    facts = done.answer.value
    if facts is not None:
        return facts
    return RunFacts(replace(done.item, files=()), {"problem": storable(done.problem)})


def _batches(facts: Iterable[RunFacts]) -> Iterator[list[RunFacts]]:
    """Yield batches in the order of their paths: all processes lock rows in the same order."""
    remaining = iter(facts)
    while batch := list(islice(remaining, _BATCH)):
        yield sorted(batch, key=lambda run_facts: run_facts.found_run.path)
