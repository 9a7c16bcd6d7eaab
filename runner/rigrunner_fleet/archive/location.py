"""The database of an archive: a file in the folder of runs, another file, or a server."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import URL, make_url
from sqlalchemy.exc import ArgumentError

from rigrunner.api.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Sequence

FILE = ".rigrunner-archive.sqlite"
"""The archive of a folder of runs, if no database is named."""
_POSTGRESQL = {"postgresql", "postgres", "postgresql+psycopg"}
_HINT = "a file such as lab.sqlite, or postgresql://user@host/database"


def location_of(database: str, folders: Sequence[Path]) -> URL:
    """Return the location of the archive: the named database, or the folder's own file.

    Raises UsageError for several folders without a database, and for an unknown kind of database.
    """
    if database:
        return _parse_location(database)
    if len(folders) != 1:
        raise UsageError(
            "several folders need one database for all", hint=f"give --database: {_HINT}"
        )
    return URL.create("sqlite", database=str((folders[0] / FILE).absolute()))


def file_of(location: URL) -> Path | None:
    """Return the file of an embedded archive; None for one on a server."""
    return Path(location.database or "") if location.drivername == "sqlite" else None


def _parse_location(database: str) -> URL:
    if "://" not in database:
        return URL.create("sqlite", database=str(Path(database).absolute()))
    try:
        url = make_url(database)
    except (ArgumentError, ValueError) as error:  # it might hold a password: not shown
        raise UsageError("the database is not a valid address", hint=_HINT) from error
    if url.drivername in _POSTGRESQL:
        return url.set(drivername="postgresql+psycopg")
    if url.drivername == "sqlite" and url.database and not url.query:
        return url.set(database=str(Path(url.database).absolute()))
    raise UsageError(f"'{url.drivername}' is not a database for archives", hint=_HINT)
