"""A check of an archive's files that can be stopped at any time and resumed later."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sqlalchemy import select

from rigrunner.runfile.scan import run_folders
from rigrunner_fleet.archive.checking.memory import last_findings, prepare, runs_to_check, store
from rigrunner_fleet.archive.checking.task import CheckedRun, Finding, Kind, RunChecker
from rigrunner_fleet.archive.indexing import known_folders, no_progress
from rigrunner_fleet.archive.schema import ROOTS, RUNS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from datetime import datetime

    from rigrunner.api.devices import StopToken
    from rigrunner.jobs import Workers
    from rigrunner_fleet.archive.database import Database


@dataclass(frozen=True)
class CheckSummary:
    """The findings of a check, with those of earlier ones on runs that it did not reach."""

    findings: tuple[Finding, ...]
    checked: int
    """The number of runs that were checked."""
    due: int
    """The number of runs to check."""
    read_bytes: int
    seconds: float

    @property
    def grave(self) -> tuple[Finding, ...]:
        """Lost and changed files: all findings but unknown files."""
        return tuple(finding for finding in self.findings if finding.kind is not Kind.UNKNOWN)


def check(
    database: Database,
    checker: RunChecker,
    workers: Workers,
    stop: StopToken,
    *,
    now: Callable[[], datetime],
    before: datetime | None = None,
    progress: Callable[[int, int], None] = no_progress,
) -> CheckSummary:
    """Check the runs of an archive, starting with the one whose last check is oldest.

    Each finding is stored at once. `before` leaves out runs that were checked since. Raises
    UsageError without an archive, and DataError if the database fails.
    """
    prepare(database)
    runs = runs_to_check(database, before)
    began_s, checked, read_bytes = time.monotonic(), 0, 0
    progress(0, len(runs))
    for outcome in workers.outcomes(checker, runs, stop):
        checked_run = outcome.answer.value
        if checked_run is None:  # its process died
            crash = Finding(outcome.item.path, Kind.DAMAGED, outcome.problem)
            checked_run = CheckedRun((crash,), outcome.item.sha256, 0)
        store(database, outcome.item, checked_run, now())
        checked, read_bytes = checked + 1, read_bytes + checked_run.read_bytes
        progress(checked, len(runs))
    seconds = time.monotonic() - began_s
    present = {(run.root, run.path) for run in runs_to_check(database, None)}
    findings = list(_unknown_runs(database))
    for location, run_findings in last_findings(database).items():
        if location in present:
            findings += run_findings
    return CheckSummary(tuple(sorted(findings)), checked, len(runs), read_bytes, seconds)


def _unknown_runs(database: Database) -> Iterator[Finding]:
    with database.reading() as connection:
        statement = select(ROOTS.c.path, RUNS.c.path).join(ROOTS, RUNS.c.root == ROOTS.c.id)
        known_runs = {(str(root), path) for root, path in connection.execute(statement)}
        roots = list(connection.scalars(select(ROOTS.c.path).order_by(ROOTS.c.id)))
    for name, folder in zip(roots, known_folders(database), strict=True):
        for run in run_folders(folder):
            if (name, run.path) not in known_runs:
                yield Finding(run.path, Kind.UNKNOWN, "the archive does not know this run")
