"""The last check of each run, stored in the archive's database.

The table is not part of the index: a rebuild from the run files keeps it.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING

from sqlalchemy import BigInteger, Column, MetaData, Table, delete, insert, select

from rigrunner_fleet.archive.checking.task import Finding, Kind, RunToCheck
from rigrunner_fleet.archive.schema import FILES, ROOTS, RUNS, TEXT, UtcTime
from rigrunner_fleet.archive.storing import root_folder

if TYPE_CHECKING:
    from collections.abc import Iterator
    from datetime import datetime

    from sqlalchemy import Connection

    from rigrunner_fleet.archive.checking.task import CheckedRun
    from rigrunner_fleet.archive.database import Database

_METADATA = MetaData()
CHECKS = Table(
    "checks",
    _METADATA,
    Column("root", TEXT, primary_key=True),
    Column("path", TEXT, primary_key=True),
    Column("checked_utc", UtcTime, nullable=False),
    Column("manifest_sha256", TEXT, nullable=False),
    Column("sha256", TEXT, nullable=False),
    Column("bytes", BigInteger, nullable=False),
    Column("findings", TEXT, nullable=False),
)


def prepare(database: Database) -> None:
    """Create the table if needed; raise UsageError without an archive."""
    with database.reading():
        pass
    with database.writing() as connection:
        _METADATA.create_all(connection)


def runs_to_check(database: Database, before: datetime | None) -> list[RunToCheck]:
    """Return the runs in the order of checking: unchecked ones first, then the oldest check.

    With `before`, only those that were last checked before then.
    """
    with database.reading() as connection:
        last_checks = {
            (row.root, row.path): (row.checked_utc, row.manifest_sha256, row.sha256)
            for row in connection.execute(select(CHECKS))
        }
        files: dict[int, dict[str, str]] = {}
        for row in connection.execute(select(FILES.c.run, FILES.c.name, FILES.c.sha256)):
            files.setdefault(row.run, {})[row.name] = row.sha256
        runs = list(_runs(database, connection, files, last_checks))
    checked_at = {location: checked_utc for location, (checked_utc, *_) in last_checks.items()}
    never = [run for run in runs if (run.root, run.path) not in checked_at]
    due = [
        (last_check, run.root, run.path, run)
        for run in runs
        if (last_check := checked_at.get((run.root, run.path)))
        and (before is None or last_check <= before)
    ]
    return [*never, *(run for *_, run in sorted(due, key=lambda entry: entry[:3]))]


def store(database: Database, run: RunToCheck, checked: CheckedRun, now: datetime) -> None:
    """Store the findings on a run, in place of the previous ones."""
    row = {
        "root": run.root,
        "path": run.path,
        "checked_utc": now,
        "manifest_sha256": run.manifest_sha256,
        "sha256": checked.sha256,
        "bytes": checked.read_bytes,
        "findings": json.dumps([asdict(finding) for finding in checked.findings]),
    }
    with database.writing() as connection:
        this_run = (CHECKS.c.root == run.root) & (CHECKS.c.path == run.path)
        connection.execute(delete(CHECKS).where(this_run))
        connection.execute(insert(CHECKS), row)


def last_findings(database: Database) -> dict[tuple[str, str], tuple[Finding, ...]]:
    """Return the findings of the last check of each run, by root and path."""
    with database.reading() as connection:
        rows = connection.execute(select(CHECKS.c.root, CHECKS.c.path, CHECKS.c.findings)).all()
    return {
        (root, path): tuple(
            Finding(entry["path"], Kind(entry["kind"]), entry["what"]) for entry in json.loads(text)
        )
        for root, path, text in rows
    }


def _runs(
    database: Database,
    connection: Connection,
    files: dict[int, dict[str, str]],
    last_checks: dict[tuple[str, str], tuple[datetime, str, str]],
) -> Iterator[RunToCheck]:
    columns = (RUNS.c.id, RUNS.c.path, RUNS.c.sealed, RUNS.c.manifest_sha256, RUNS.c.problem)
    statement = select(*columns, ROOTS.c.name, ROOTS.c.path.label("place")).join(
        ROOTS, RUNS.c.root == ROOTS.c.id
    )
    for row in connection.execute(statement.order_by(ROOTS.c.name, RUNS.c.path)):
        _, manifest, sha256 = last_checks.get((row.name, row.path), (None, "", ""))
        yield RunToCheck(
            root=row.name,
            path=row.path,
            folder=root_folder(database.file, row.place) / row.path,
            sealed=row.sealed is not False,
            manifest_sha256=row.manifest_sha256 or "",
            files=files.get(row.id, {}),
            sha256=sha256 if manifest == (row.manifest_sha256 or "") else "",  # else another run's
            problem=row.problem,
        )
