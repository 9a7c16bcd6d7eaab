"""The tables of an archive, the same for SQLite and PostgreSQL.

Numbers are in SI units, named by the column; those of a result are in its own unit. Everything
can be rebuilt from the run files.
"""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    DateTime,
    Double,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    Table,
    Text,
    TypeDecorator,
    UniqueConstraint,
    select,
    type_coerce,
)

from rigrunner_fleet.archive.documents import key

if TYPE_CHECKING:
    from sqlalchemy import BindParameter, ColumnElement, Dialect

VERSION = 4
"""Version of the tables; indexing brings an older archive up to date."""


class UtcTime(TypeDecorator[datetime]):
    """A time with zone, stored as UTC without zone, since SQLite has no zones."""

    impl = DateTime
    cache_ok = True

    @property
    def python_type(self) -> type[datetime]:
        """The type in Python."""
        return datetime

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:  # noqa: ARG002  (SQLAlchemy's signature)
        """Return the time in UTC, without zone."""
        return None if value is None else value.astimezone(UTC).replace(tzinfo=None)

    def process_result_value(self, value: datetime | None, dialect: Dialect) -> datetime | None:  # noqa: ARG002  (SQLAlchemy's signature)
        """Return the time with its zone."""
        return None if value is None else value.replace(tzinfo=UTC)


class Hex(TypeDecorator[str]):
    """Hexadecimal digits, stored as half as many bytes."""

    impl = LargeBinary
    cache_ok = True

    @property
    def python_type(self) -> type[str]:
        """The type in Python."""
        return str

    def process_bind_param(self, value: str | None, dialect: Dialect) -> bytes | None:  # noqa: ARG002  (SQLAlchemy's signature)
        """Return the bytes."""
        return None if value is None else bytes.fromhex(value)

    def process_result_value(self, value: bytes | None, dialect: Dialect) -> str | None:  # noqa: ARG002  (SQLAlchemy's signature)
        """Return the digits, in lower case."""
        return None if value is None else value.hex()


TEXT = Text().with_variant(Text(collation="C"), "postgresql")
"""Sorted by code points, in every locale of the server."""
METADATA = MetaData()

ABOUT = Table(
    "archive",
    METADATA,
    Column("name", TEXT, primary_key=True),
    Column("value", TEXT, nullable=False),
)


class Key(TypeDecorator[str]):
    """A text that is short enough for an index."""

    impl = TEXT
    cache_ok = True

    def process_bind_param(self, value: str | None, dialect: Dialect) -> str | None:  # noqa: ARG002  (SQLAlchemy's signature)
        """Return the text, shortened to the limit of an index."""
        return key(value)


TEXTS = Table(
    "texts",
    METADATA,
    Column("id", Integer, primary_key=True),
    Column("text", Key, nullable=False, unique=True),
)


class SharedText(TypeDecorator[str]):
    """A text that many rows have: it is stored once, in TEXTS, and its id in each row.

    In a statement such a column is its text, except in ORDER BY: there it is `text_of`.
    """

    impl = Integer
    cache_ok = True

    @property
    def python_type(self) -> type[str]:
        """The type in Python."""
        return str

    def bind_expression(self, bindparam: BindParameter[str]) -> ColumnElement[Any]:
        """Return the id of a text; NULL for one that no row has."""
        text = type_coerce(bindparam, Key)
        return select(TEXTS.c.id).where(TEXTS.c.text == text).scalar_subquery()

    def column_expression(self, column: ColumnElement[str]) -> ColumnElement[Any]:
        """Return the text of a column."""
        return text_of(column)


def text_of(column: ColumnElement[str]) -> ColumnElement[str]:
    """Return the text of a column of shared texts."""
    return select(TEXTS.c.text).where(TEXTS.c.id == column).scalar_subquery()


ROOTS = Table(
    "roots",
    METADATA,
    Column("id", Integer, primary_key=True),
    Column("name", TEXT, nullable=False, unique=True),
    Column("path", TEXT, nullable=False),
)

RUNS = Table(
    "runs",
    METADATA,
    Column("id", Integer, primary_key=True),
    Column("root", ForeignKey("roots.id"), nullable=False),
    Column("path", TEXT, nullable=False),
    Column("stamp", Hex, nullable=False),
    Column("missing", Boolean, nullable=False),
    Column("problem", TEXT, nullable=False),
    Column("run_id", TEXT),
    Column("started_utc", UtcTime),
    Column("ended_utc", UtcTime),
    Column("sealed", Boolean),
    Column("outcome", SharedText),
    Column("reason", TEXT),
    Column("procedure", TEXT),
    Column("revision", TEXT),
    Column("title", SharedText),
    Column("rig", TEXT),
    Column("mandrel", SharedText),
    Column("specimen", TEXT),
    Column("type", TEXT),
    Column("lot", TEXT),
    Column("operator", TEXT),
    Column("approval", SharedText),
    Column("imported", Boolean),
    Column("replayed", Boolean),
    Column("simulated", Boolean),
    Column("program", SharedText),
    Column("no_load_run", TEXT),
    Column("recordings", Integer),
    Column("measurand", SharedText),
    Column("symbol", SharedText),
    Column("method", SharedText),
    Column("torque_nm", Double),
    Column("u_nm", Double),
    Column("expanded_nm", Double),
    Column("dof", Double),
    Column("raw_peak_nm", Double),
    Column("verdict", TEXT),
    Column("rule", SharedText),
    Column("limit_text", SharedText),
    Column("probability_of_conformity", Double),
    Column("failed_checks", Integer),
    Column("digest_sha256", Hex),
    Column("manifest_sha256", Hex),
    Column("bytes", BigInteger),
    UniqueConstraint("root", "path"),
    Index("runs_by_start", "started_utc").ddl_if(dialect="sqlite"),
    Index("runs_by_run_id", "run_id"),
    Index("runs_by_specimen", "specimen"),
    Index("runs_by_lot", "lot"),
    Index("runs_by_rig", "rig"),
    Index("runs_by_torque", "torque_nm"),
)


# As in SQLite, where NULL comes first: the newest runs are then found without sorting all.
Index("runs_by_start", RUNS.c.started_utc.nulls_first()).ddl_if(dialect="postgresql")


def _run_table(name: str, key: list[Column[Any]], *columns: Column[Any]) -> Table:
    """Return a table with several rows per run, ordered by key."""
    run: Column[Any] = Column("run", ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True)
    # Without row ids SQLite keeps the rows of a run together, in the order of the key.
    return Table(name, METADATA, run, *key, *columns, sqlite_with_rowid=False)


POINTS = _run_table(
    "points",
    [Column("number", Integer, primary_key=True, autoincrement=False)],
    Column("recording", SharedText),
    Column("set_frequency_hz", Double),
    Column("frequency_hz", Double),
    Column("load_n", Double),
    Column("cycles", Integer),
    Column("raw_peak_nm", Double),
    Column("raw_peak_sd_nm", Double),
    Column("torque_nm", Double),
    Column("u_nm", Double),
    Column("expanded_nm", Double),
    Column("dof", Double),
)

Index("points_by_frequency", POINTS.c.set_frequency_hz, POINTS.c.torque_nm)

RESULTS = _run_table(
    "results",
    [Column("number", Integer, primary_key=True, autoincrement=False)],
    Column("name", SharedText),
    Column("symbol", SharedText),
    Column("measurand", SharedText),
    Column("place", SharedText),
    Column("value", Double),
    Column("u", Double),
    Column("expanded", Double),
    Column("dof", Double),
    Column("unit", SharedText),
    Column("readings", Integer),
    Column("lower", Double),
    Column("upper", Double),
    Column("verdict", SharedText),
    Column("si_value", Double),
    Column("si_unit", SharedText),
)

COORDINATES = _run_table(
    "coordinates",
    [
        Column("number", Integer, primary_key=True, autoincrement=False),
        Column("name", SharedText, primary_key=True),
    ],
    Column("short", SharedText),
    Column("value", Double),
    Column("unit", SharedText),
    Column("text", SharedText),
)

FIGURES = _run_table(
    "figures",
    [Column("source", SharedText, primary_key=True), Column("name", SharedText, primary_key=True)],
    Column("value", Double),
    Column("u", Double),
    Column("dof", Double),
    Column("unit", SharedText),
)

INPUTS = _run_table(
    "inputs", [Column("name", SharedText, primary_key=True)], Column("value", TEXT, nullable=False)
)

DECISIONS = _run_table(
    "decisions",
    [Column("number", Integer, primary_key=True, autoincrement=False)],
    Column("file", SharedText),
    Column("in_force", Boolean, nullable=False),
    Column("verdict", SharedText),
    Column("rule", SharedText),
    Column("limit_text", SharedText),
    Column("limit_source", SharedText),
    Column("probability_of_conformity", Double),
    Column("decided_utc", UtcTime),
    Column("reason", TEXT),
    Column("by", SharedText),
    Column("why", TEXT),
)

FILES = _run_table(
    "files",
    [Column("name", SharedText, primary_key=True)],
    Column("bytes", BigInteger, nullable=False),
    Column("modified_ns", BigInteger, nullable=False),
    Column("sha256", Hex, nullable=False),
)

PARTS = (POINTS, RESULTS, COORDINATES, FIGURES, INPUTS, DECISIONS, FILES)
"""Tables with several rows per run."""
TABLES = {table.name: table for table in (RUNS, *PARTS)}
"""All tables by name."""
