"""Query an archive: used by the command line, notebooks and trends."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import UsageError
from rigrunner_fleet.archive.database import Database
from rigrunner_fleet.archive.filters import filters_of
from rigrunner_fleet.archive.location import location_of
from rigrunner_fleet.archive.rows import FOLDER, Rows
from rigrunner_fleet.archive.searching import select_rows
from rigrunner_fleet.archive.storing import root_folder

if TYPE_CHECKING:
    from rigrunner_fleet.archive.filters import Filters

_PLACE = 2
"""The last columns of a statement: the root and the path of a run folder."""


def open_archive(runs: Path | str = "runs", database: str = "") -> Database:
    """Return the archive of a folder of runs, or the one in that database."""
    return Database(location_of(database, [Path(runs)]))


def query(
    table: str = "runs",
    *,
    runs: Path | str = "runs",
    database: str = "",
    limit: int | None = None,
    **filters: Any,
) -> Rows:
    """Return the rows of a table of an archive that match the filters.

    The archive is that of the folder `runs`, or the one in `database`. Tables and filters are on
    the page docs/reference/archive.md. Raises UsageError for an invalid query, and DataError if the
    database fails.
    """
    with closing(open_archive(runs, database)) as archive:
        return rows(archive, table, filters_of(**filters), limit=limit)


def rows(archive: Database, table: str, filters: Filters, *, limit: int | None = None) -> Rows:
    """Return the rows of a table of an open archive; raises as `query` does."""
    if limit is not None and limit < 1:
        raise UsageError(f"a limit of {limit} selects nothing")
    with archive.reading() as connection:
        statement = select_rows(table, filters, connection.dialect, limit)
        hits = connection.execute(statement).all()
    columns = {
        column.name: column.type.python_type for column in statement.selected_columns[:-_PLACE]
    }
    roots = {root: root_folder(archive.file, root) for root in {row[-_PLACE] for row in hits}}
    folders = (str(PurePath(roots[row[-_PLACE]], row[-1])) for row in hits)
    return Rows(
        table=table,
        columns={**columns, FOLDER: str},
        values=tuple((*row[:-_PLACE], folder) for row, folder in zip(hits, folders, strict=True)),
    )
