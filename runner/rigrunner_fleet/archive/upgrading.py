"""Bring the tables of an older version up to date."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from sqlalchemy import Column, MetaData, Table, delete, inspect, or_, select, text, update

from rigrunner.runfile.scan import FoundRun
from rigrunner_fleet.archive.run_facts import RunFacts
from rigrunner_fleet.archive.schema import (
    ABOUT,
    METADATA,
    PARTS,
    RESULTS,
    RUNS,
    TEXT,
    VERSION,
    Hex,
    SharedText,
)
from rigrunner_fleet.archive.storing import store

if TYPE_CHECKING:
    from sqlalchemy import Connection


def upgrade(connection: Connection, version: str) -> None:
    """Keep only those runs whose files are gone or damaged, in tables of this version.

    All others are read again when they are indexed. Before version 4 one limit of a result stood
    for several, such as a minimum alone: what is kept has limits only where it has both.
    """
    if version == "3":  # its tables are those of this version
        connection.execute(delete(RUNS).where(~RUNS.c.missing, RUNS.c.problem == ""))
    else:
        _recreate(connection)
    one_sided = or_(RESULTS.c.lower.is_(None), RESULTS.c.upper.is_(None))
    connection.execute(update(RESULTS).where(one_sided).values(lower=None, upper=None))
    connection.execute(update(ABOUT).where(ABOUT.c.name == "version").values(value=str(VERSION)))


def _recreate(connection: Connection) -> None:
    existing = inspect(connection).get_table_names()
    runs, *parts = (_rename_table(connection, t) for t in (RUNS, *PARTS) if t.name in existing)
    METADATA.create_all(connection)
    unreadable = select(runs.c.id).where(or_(runs.c.missing, runs.c.problem != ""))
    for run in connection.scalars(unreadable).all():
        _store(connection, run, runs, parts)
    for table in (*parts, runs):
        table.drop(connection)


def _rename_table(connection: Connection, table: Table) -> Table:
    """Rename a table of version 1 or 2, where every text was in its row; return it."""
    for index in table.indexes:
        index.drop(connection, checkfirst=True)
    name = f"{table.name}_before"
    connection.execute(text(f"ALTER TABLE {table.name} RENAME TO {name}"))
    texts = (SharedText, Hex)
    columns = (Column(c.name, TEXT if isinstance(c.type, texts) else c.type) for c in table.c)
    return Table(name, MetaData(), *columns)


def _store(connection: Connection, run: int, runs: Table, parts: list[Table]) -> None:
    (row,) = _rows(connection, runs, runs.c.id == run)
    root, path = row["root"], row["path"]
    of_run = {name: value for name, value in row.items() if name not in {"id", "root", "stamp"}}
    of_parts = {
        part.name.removesuffix("_before"): _rows(connection, part, part.c.run == run)
        for part in parts
    }
    store(connection, root, [RunFacts(FoundRun(path, Path(path), ()), of_run, of_parts)])


def _rows(connection: Connection, table: Table, condition: Any) -> list[dict[str, Any]]:
    columns = [column for column in table.c if column.name != "run"]
    result = connection.execute(select(*columns).where(condition))
    return [dict(row) for row in result.mappings()]
