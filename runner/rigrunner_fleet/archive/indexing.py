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


def unseen(done: int, of: int) -> None:
    """Ignore the progress."""


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
    progress: Progress = unseen,
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
    work = [_look(database, folder, again=again) for folder in folders]
    count = _Count(progress, sum(len(each.stale) for each in work))
    return [_bring_up_to_date(database, each, workers, count) for each in work]


def rebuild(
    database: Database,
    folders: Sequence[Path],
    *,
    workers: Workers = HERE,
    progress: Progress = unseen,
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
    known: Mapping[str, Known]
    there: Mapping[str, FoundRun]
    stale: Sequence[FoundRun]
    unread: Sequence[tuple[str, str]]
    """Path and problem of what is skipped: unreadable folders, paths that are too long."""


def _look(database: Database, folder: Path, *, again: bool) -> _Work:
    with database.writing() as connection:
        root = root_of(connection, database.file, folder)
        known = known_runs(connection, root)
    unread: list[tuple[str, str]] = []
    every = list(run_folders(folder, lambda *told: unread.append(told)))
    there = {found.path: found for found in every if len(found.path) <= LONGEST_KEY}
    long = "its path is too long for an archive"
    unread += [(found.path, long) for found in every if found.path not in there]
    stale = []
    for found in there.values():
        row = known.get(found.path)
        is_read = row is not None and not row.missing and found.stamp and row.stamp == found.stamp
        if again or not is_read:
            stale.append(found)
    return _Work(folder, root, known, there, stale, unread)


def _bring_up_to_date(database: Database, work: _Work, workers: Workers, count: _Count) -> Indexed:
    unreadable = [*work.unread]
    for facts in _batches(map(_facts, workers.outcomes(read_facts, work.stale, Event()))):
        with database.writing() as connection:
            store(connection, work.root, facts)
        unreadable += [(each.found.path, each.problem) for each in facts if each.problem]
        count.add(len(facts))
    gone = [known.id for path, known in work.known.items() if path not in work.there]
    with database.writing() as connection:
        mark_missing(connection, gone)
        forget_moved(connection, work.root)
        left = [path for path, row in known_runs(connection, work.root).items() if row.missing]
    return Indexed(
        folder=work.folder,
        runs=len(work.there),
        new=sum(found.path not in work.known for found in work.stale),
        changed=sum(found.path in work.known for found in work.stale),
        unreadable=tuple(sorted(unreadable)),
        missing=tuple(sorted(left)),
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
    read = done.answer.value
    if read is not None:
        return read
    return RunFacts(replace(done.item, files=()), {"problem": storable(done.problem)})


def _batches(every: Iterable[RunFacts]) -> Iterator[list[RunFacts]]:
    """Yield batches in the order of their paths: all processes lock rows in the same order."""
    rest = iter(every)
    while batch := list(islice(rest, _BATCH)):
        yield sorted(batch, key=lambda one: one.found.path)
