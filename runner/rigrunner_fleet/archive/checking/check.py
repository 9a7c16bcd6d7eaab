"""A check of an archive's files that can be stopped at any time and resumed later."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sqlalchemy import select

from rigrunner.runfile.scan import run_folders
from rigrunner_fleet.archive.checking.memory import found_before, prepare, remember, runs_to_check
from rigrunner_fleet.archive.checking.task import Finding, Kind, Look, RunLook
from rigrunner_fleet.archive.indexing import known_folders, unseen
from rigrunner_fleet.archive.schema import ROOTS, RUNS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from datetime import datetime

    from rigrunner.api.devices import StopToken
    from rigrunner.jobs import Workers
    from rigrunner_fleet.archive.database import Database


@dataclass(frozen=True)
class Checked:
    """The findings of a check, with those of earlier ones on runs that it did not reach."""

    findings: tuple[Finding, ...]
    looked: int
    """The number of runs that were checked."""
    due: int
    """The number of runs to check."""
    read_bytes: int
    seconds: float

    @property
    def grave(self) -> tuple[Finding, ...]:
        """Lost and changed files: all findings but unknown files."""
        return tuple(each for each in self.findings if each.kind is not Kind.UNKNOWN)


def check(
    database: Database,
    look: Look,
    workers: Workers,
    stop: StopToken,
    *,
    now: Callable[[], datetime],
    before: datetime | None = None,
    progress: Callable[[int, int], None] = unseen,
) -> Checked:
    """Check the runs of an archive, starting with the one whose last check is oldest.

    Each finding is stored at once. `before` leaves out runs that were checked since. Raises
    UsageError without an archive, and DataError if the database fails.
    """
    prepare(database)
    runs = runs_to_check(database, before)
    began_s, looked, read_bytes = time.monotonic(), 0, 0
    progress(0, len(runs))
    for done in workers.outcomes(look, runs, stop):
        found = done.answer.value
        if found is None:  # its process died
            died = Finding(done.item.path, Kind.DAMAGED, done.problem)
            found = RunLook((died,), done.item.sha256, 0)
        remember(database, done.item, found, now())
        looked, read_bytes = looked + 1, read_bytes + found.read_bytes
        progress(looked, len(runs))
    seconds = time.monotonic() - began_s
    there = {(run.root, run.path) for run in runs_to_check(database, None)}
    findings = list(_unknown_runs(database))
    for place, some in found_before(database).items():
        if place in there:
            findings += some
    return Checked(tuple(sorted(findings)), looked, len(runs), read_bytes, seconds)


def _unknown_runs(database: Database) -> Iterator[Finding]:
    with database.reading() as connection:
        statement = select(ROOTS.c.path, RUNS.c.path).join(ROOTS, RUNS.c.root == ROOTS.c.id)
        known = {(str(root), path) for root, path in connection.execute(statement)}
        roots = list(connection.scalars(select(ROOTS.c.path).order_by(ROOTS.c.id)))
    for name, folder in zip(roots, known_folders(database), strict=True):
        for run in run_folders(folder):
            if (name, run.path) not in known:
                yield Finding(run.path, Kind.UNKNOWN, "the archive does not know this run")
