"""The connection to an archive's database, with the same tables on SQLite and PostgreSQL."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from sqlalchemy import Connection, Engine, create_engine, event, insert, inspect, select
from sqlalchemy.exc import DBAPIError, OperationalError, SQLAlchemyError

from rigrunner.api.errors import DataError, MissingPackageError, UsageError
from rigrunner_fleet.archive.location import file_of
from rigrunner_fleet.archive.schema import ABOUT, METADATA, VERSION
from rigrunner_fleet.archive.upgrading import upgrade

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sqlalchemy import URL

_PATIENCE_S = 60
"""How long SQLite waits for another writing process."""
_WRITES = "rigrunner_writes"
_DAMAGED = ("SQLITE_CORRUPT", "SQLITE_NOTADB")
_OLDER = tuple(str(number) for number in range(1, VERSION))
_NO_SERVER = "is the server running, and may this machine reach it? A file needs no server"
_REBUILD = "'rigrunner archive index FOLDER' rebuilds it from the run files"


class Database:
    """An archive's database; its errors become DataErrors, without its password."""

    def __init__(self, location: URL) -> None:
        self.location = location
        self.file = file_of(location)
        self._engine = _engine(location)

    @property
    def shown(self) -> str:
        """Its location as text, without its password."""
        if self.file is not None:
            return str(self.file)
        return self.location.set(drivername="postgresql").render_as_string(hide_password=True)

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Yield a connection on one state of the archive; raise UsageError without an archive."""
        if self.file is not None and not self.file.is_file():
            raise self._no_archive()
        with self._data_errors(), self._engine.connect() as connection:
            self._check(connection)
            yield connection

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """Yield a connection in a transaction, which is committed if nothing is raised."""
        options = {_WRITES: True}
        with (
            self._data_errors(),
            self._engine.connect().execution_options(**options) as connection,
            connection.begin(),
        ):
            yield connection

    def make(self) -> None:
        """Create missing tables, and update those of an older version.

        Raises DataError for tables of a newer version.
        """
        if self.file is not None and not self.file.parent.is_dir():
            raise UsageError(f"there is no folder {self.file.parent}")
        if self.file is not None:
            # Readers read during writes; the file keeps this setting.
            with self._data_errors(), self._engine.connect() as connection:
                connection.connection.driver_connection.execute("PRAGMA journal_mode=WAL")  # type: ignore[union-attr]  # it is open
        try:
            with self.writing() as connection:
                self._make(connection)
        except DataError:
            if not self._exists():  # by another process, at the same moment
                raise

    def empty(self) -> None:
        """Drop all tables and create them again."""
        with self.writing() as connection:
            METADATA.drop_all(connection)
            self._make(connection)

    def close(self) -> None:
        """Close the database."""
        self._engine.dispose()

    def _exists(self) -> bool:
        try:
            with self.reading():
                return True
        except UsageError:
            return False

    def _make(self, connection: Connection) -> None:
        if inspect(connection).has_table(ABOUT.name):
            version = self._version(connection)
            if version in _OLDER:
                upgrade(connection, version)
            self._check(connection)
            return
        METADATA.create_all(connection)
        connection.execute(insert(ABOUT).values(name="version", value=str(VERSION)))

    def _check(self, connection: Connection) -> None:
        if not inspect(connection).has_table(ABOUT.name):
            raise self._no_archive()
        version = self._version(connection)
        if version != str(VERSION):
            older = "'rigrunner archive index FOLDER' updates it"
            newer = "'rigrunner archive rebuild FOLDER' rebuilds it from the run files"
            raise DataError(
                f"the archive {self.shown} is of version {version}, this program's is {VERSION}",
                hint=older if version in _OLDER else newer,
            )

    def _version(self, connection: Connection) -> str | None:
        version: str | None = connection.scalar(
            select(ABOUT.c.value).where(ABOUT.c.name == "version")
        )
        return version

    def _no_archive(self) -> UsageError:
        return UsageError(
            f"there is no archive {self.shown}", hint="'rigrunner archive index FOLDER' creates it"
        )

    @contextmanager
    def _data_errors(self) -> Iterator[None]:
        try:
            yield
        except SQLAlchemyError as error:
            # There was no connection: PostgreSQL gives such a failure no SQLSTATE.
            sqlstate = getattr(getattr(error, "orig", None), "sqlstate", "")
            if isinstance(error, OperationalError) and sqlstate is None:
                message = f"the database {self.shown} cannot be reached: {_message(error)}"
                raise DataError(message, hint=_NO_SERVER) from error
            raise DataError(
                f"the database {self.shown} reported an error", hint=_message(error)
            ) from error


def _message(error: SQLAlchemyError) -> str:
    """Return the message of the database, on one line."""
    message = str(error.orig) if isinstance(error, DBAPIError) else str(error)
    line = " ".join(message.split())
    if str(getattr(getattr(error, "orig", None), "sqlite_errorname", "")).startswith(_DAMAGED):
        return f"{line}: if it is an archive, remove the file; {_REBUILD}"
    return line


def _engine(location: URL) -> Engine:
    try:
        if location.drivername != "sqlite":
            return create_engine(location, connect_args={"application_name": "rigrunner archive"})
    except ModuleNotFoundError as error:
        raise MissingPackageError(
            f"an archive on PostgreSQL needs {error.name}",
            hint="pip install 'rigrunner[postgresql]'",
        ) from error
    engine = create_engine(location, connect_args={"timeout": _PATIENCE_S})
    event.listen(engine, "connect", _set_up_sqlite)
    event.listen(engine, "begin", _begin_sqlite)
    return engine


def _set_up_sqlite(connection: Any, _: object) -> None:
    connection.isolation_level = None  # transactions begin where we say: see _begin_sqlite
    connection.execute("PRAGMA foreign_keys=ON")
    connection.execute("PRAGMA synchronous=NORMAL")  # after a power cut it is intact, maybe older


def _begin_sqlite(connection: Connection) -> None:
    """Begin a transaction; a writer locks at once, and so waits for others instead of failing."""
    writes = connection.get_execution_options().get(_WRITES)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")
