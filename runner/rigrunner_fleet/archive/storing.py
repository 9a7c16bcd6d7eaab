"""Store runs in an archive: each run completely, or not at all."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sqlalchemy import bindparam, delete, insert, select, update
from sqlalchemy.dialects import postgresql, sqlite

from rigrunner_fleet.archive.schema import PARTS, ROOTS, RUNS, TEXTS, SharedText

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from sqlalchemy import Connection, Executable, Table

    from rigrunner_fleet.archive.run_facts import RunFacts

_CHUNK = 500
"""Rows that one statement names by their id: SQLite allows 32,766, old versions 999."""
_SHARED = {
    table.name: [column.name for column in table.c if isinstance(column.type, SharedText)]
    for table in (RUNS, *PARTS)
}
"""The columns of shared texts, by table."""


def root_of(connection: Connection, archive: Path | None, folder: Path) -> int:
    """Return the id of a root, which is stored if it is new.

    `archive`: the file of an embedded archive; None on a server.
    """
    name, path = _naming(archive, folder)
    root: int | None = connection.scalar(select(ROOTS.c.id).where(ROOTS.c.name == name))
    if root is not None:
        return root
    return _upsert(connection, ROOTS, {"name": name, "path": path}, "name")


def root_folder(archive: Path | None, path: str) -> Path:
    """Return the folder of a root, from its row in the archive."""
    return (archive.parent / path).resolve() if archive else Path(path)


@dataclass(frozen=True)
class Known:
    """What an archive knows of a run's files."""

    id: int
    stamp: str
    missing: bool


def known_runs(connection: Connection, root: int) -> dict[str, Known]:
    """Return the known runs of a root, by path."""
    columns = (RUNS.c.path, RUNS.c.id, RUNS.c.stamp, RUNS.c.missing)
    rows = connection.execute(select(*columns).where(RUNS.c.root == root))
    return {path: Known(run, stamp, missing) for path, run, stamp, missing in rows}


def store(connection: Connection, root: int, runs: Sequence[RunFacts]) -> None:
    """Store runs in the archive, in place of earlier ones at these paths.

    For a run that was readable once and is damaged now, the earlier facts stay, with its problem.
    """
    _store_shared_texts(connection, runs)
    parts: dict[str, list[dict[str, Any]]] = {table.name: [] for table in PARTS}
    ids = []
    for facts in runs:
        row = {
            "root": root,
            "path": facts.found_run.path,
            "stamp": facts.found_run.stamp,
            "missing": False,
            **facts.run,
        }
        run = _upsert(connection, RUNS, row, "root", "path")
        if not facts.problem:
            ids.append(run)
        for name, rows in facts.parts.items():
            parts[name] += [{"run": run, **part_row} for part_row in rows]
    for table in PARTS:
        for chunk in _chunks(ids):
            connection.execute(delete(table).where(table.c.run.in_(chunk)))
        if parts[table.name]:
            connection.execute(insert(table), parts[table.name])


def _store_shared_texts(connection: Connection, runs: Sequence[RunFacts]) -> None:
    """Store the texts that are shared and not known yet, in the order of all processes."""
    texts = {
        text
        for facts in runs
        for name, rows in {RUNS.name: [facts.run], **facts.parts}.items()
        for column in _SHARED[name]
        for row in rows
        if (text := row.get(column)) is not None
    }
    if texts:
        inserting = _inserting(connection.dialect.name, TEXTS)
        connection.execute(
            inserting.on_conflict_do_nothing(),
            [{"text": text} for text in sorted(texts)],
        )


def mark_missing(connection: Connection, ids: Iterable[int]) -> None:
    """Mark runs whose files are gone."""
    rows = [{"gone": run} for run in ids]
    if rows:
        connection.execute(
            update(RUNS).where(RUNS.c.id == bindparam("gone")).values(missing=True), rows
        )


def forget_moved(connection: Connection, root: int) -> None:
    """Remove runs whose files are gone if the same run exists under another path."""
    other = RUNS.alias("other")
    moved = (
        select(RUNS.c.id)
        .join(
            other,
            (other.c.run_id == RUNS.c.run_id) & (other.c.digest_sha256 == RUNS.c.digest_sha256),
        )
        .where(RUNS.c.root == root, RUNS.c.missing, ~other.c.missing)
    )
    for chunk in _chunks(list(connection.scalars(moved))):
        connection.execute(delete(RUNS).where(RUNS.c.id.in_(chunk)))


def _naming(archive: Path | None, folder: Path) -> tuple[str, str]:
    """Return the name and the path of a root: relative to an embedded archive, or on a machine.

    So a folder that holds its archive can be moved, and many machines can share a server.
    """
    absolute = folder.resolve()
    if archive is None:
        return f"{platform.node()}:{absolute.as_posix()}", absolute.as_posix()
    home = archive.parent.resolve()
    path = absolute.relative_to(home) if absolute.is_relative_to(home) else absolute
    return path.as_posix(), path.as_posix()


def _upsert(connection: Connection, table: Table, row: dict[str, Any], *key: str) -> int:
    """Insert a row, or replace the one with the same key; return its id.

    The row is locked until the transaction ends, so that two processes write one after the other.
    """
    statement = _upserting(connection.dialect.name, table, tuple(row), key)
    run: int = connection.execute(statement, row).scalar_one()
    return run


@cache
def _upserting(
    dialect: str, table: Table, columns: tuple[str, ...], key: tuple[str, ...]
) -> Executable:
    """Return the statement, which takes longer to build than to execute."""
    statement = _inserting(dialect, table).values({name: bindparam(name) for name in columns})
    values = {name: statement.excluded[name] for name in columns}
    return statement.on_conflict_do_update(index_elements=key, set_=values).returning(table.c.id)


def _inserting(dialect: str, table: Table) -> sqlite.Insert | postgresql.Insert:
    return sqlite.insert(table) if dialect == "sqlite" else postgresql.insert(table)


def _chunks(ids: list[int]) -> Iterable[list[int]]:
    return (ids[start : start + _CHUNK] for start in range(0, len(ids), _CHUNK))
