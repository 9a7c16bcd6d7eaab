"""Filters as SQL. Every value is a parameter of the statement, none is part of its text."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from sqlalchemy import ColumnElement, and_, exists, or_, select, true

from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.errors import UsageError
from rigrunner.api.places import SAME
from rigrunner.api.units import si_symbol
from rigrunner_fleet.archive.filters import NONE
from rigrunner_fleet.archive.schema import (
    COORDINATES,
    FIGURES,
    INPUTS,
    POINTS,
    RESULTS,
    ROOTS,
    RUNS,
    TABLES,
    SharedText,
    text_of,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from sqlalchemy import Dialect, Select

    from rigrunner.api.quantity import Quantity
    from rigrunner_fleet.archive.filters import Filters
    from rigrunner_fleet.archive.ranges import Range

_HIDDEN = {"id", "root", "stamp", "run"}
"""Internal columns of the archive."""
CONTEXT = ("run_id", "started_utc", "rig", "procedure", "revision", "specimen", "type", "lot")
"""Columns of the run that come before those of tables with several rows per run."""
_POINT_RANGES = ("frequency", "load")
_ESCAPE = "\\"
_LAST = "\U0010ffff"
"""Sorts after every continuation of a text."""


def select_rows(table: str, filters: Filters, dialect: Dialect, limit: int | None) -> Select[Any]:
    """Return the rows of a table, oldest run first; of more than `limit` runs only the newest.

    For a table other than `runs`, the rows of the selected runs are returned; of points and
    results, only the matching ones. Raises UsageError for an unknown table.
    """
    if table not in TABLES:
        raise UsageError(
            f"there is no table '{table}' in an archive", hint=f"there are: {', '.join(TABLES)}"
        )
    runs = select(RUNS.c.id).where(*_conditions(filters, dialect))
    if limit is not None:
        runs = runs.order_by(RUNS.c.started_utc.desc().nulls_last(), RUNS.c.id.desc()).limit(limit)
    place = [ROOTS.c.path.label("root"), RUNS.c.path.label("place")]
    source = RUNS.join(ROOTS, ROOTS.c.id == RUNS.c.root)
    columns: list[ColumnElement[Any]] = [column for column in RUNS.c if column.name not in _HIDDEN]
    order: list[ColumnElement[Any]] = [RUNS.c.started_utc.nulls_first(), RUNS.c.id]
    conditions: list[ColumnElement[bool]] = [RUNS.c.id.in_(runs)]
    if table != RUNS.name:
        part = TABLES[table]
        columns = [RUNS.c[name] for name in CONTEXT]
        columns += [column for column in part.c if column.name not in _HIDDEN]
        source = source.join(part, part.c.run == RUNS.c.id)
        key = [column for column in part.primary_key.columns if column.name != "run"]
        order += [
            text_of(column) if isinstance(column.type, SharedText) else column for column in key
        ]
    if table == POINTS.name:
        conditions += _point_conditions(filters.ranges)
    if table == RESULTS.name:
        conditions += [or_(*_result_conditions(filters)), *_coordinate_conditions(filters)]
    return select(*columns, *place).select_from(source).where(*conditions).order_by(*order)


def _conditions(filters: Filters, dialect: Dialect) -> Iterator[ColumnElement[bool]]:
    for name, patterns in filters.texts.items():
        yield or_(*(_text(RUNS.c[name], pattern, dialect) for pattern in patterns))
    for name, patterns in filters.inputs.items():
        matching = or_(*(_text(INPUTS.c.value, pattern, dialect) for pattern in patterns))
        yield exists().where(INPUTS.c.run == RUNS.c.id, INPUTS.c.name == name, matching)
    yield from _value_conditions(filters)
    if filters.since is not None:
        yield RUNS.c.started_utc >= filters.since
    if filters.until is not None:
        yield RUNS.c.started_utc < filters.until
    if filters.real:
        yield and_(~RUNS.c.simulated, ~RUNS.c.replayed)
    if not filters.copies:
        yield ~_is_copy()


def _value_conditions(filters: Filters) -> Iterator[ColumnElement[bool]]:
    for name, value_range in filters.figures.items():
        yield exists().where(FIGURES.c.run == RUNS.c.id, *_figure(name, value_range))
    if filters.results or filters.where:
        for named in _result_conditions(filters):
            yield exists().where(
                RESULTS.c.run == RUNS.c.id, named, *_coordinate_conditions(filters)
            )
    if any(name in filters.ranges for name in _POINT_RANGES):
        of_point = _point_conditions(filters.ranges)
        if _is_selective(filters):
            yield exists().where(POINTS.c.run == RUNS.c.id, *of_point)
        else:
            yield RUNS.c.id.in_(select(POINTS.c.run).where(*of_point))
    else:
        for name, value_range in filters.ranges.items():
            column: ColumnElement[Any] = RUNS.c[_COLUMNS[name]]
            # The sum hides the index of the values from SQLite.
            yield _within(column + 0.0 if _is_selective(filters) else column, value_range)


def _is_selective(filters: Filters) -> bool:
    """Return whether an index of the runs themselves finds few: values are then checked one by one.

    Otherwise an index of the values is used. SQLite cannot tell which of two indices finds fewer.
    """
    names = {*filters.texts} & {"specimen", "lot"}
    return bool(names or filters.since or filters.until)


_COLUMNS: Mapping[str, str] = {
    "torque": "torque_nm",
    "uncertainty": "expanded_nm",
    "raw_peak": "raw_peak_nm",
    "frequency": "set_frequency_hz",
    "load": "load_n",
}


def _point_conditions(ranges: Mapping[str, Range]) -> list[ColumnElement[bool]]:
    """Return the conditions on a set-point, if set-points are filtered."""
    if not any(name in ranges for name in _POINT_RANGES):
        return []
    return [_within(POINTS.c[_COLUMNS[name]], value_range) for name, value_range in ranges.items()]


def _figure(name: str, value_range: Range) -> tuple[ColumnElement[bool], ...]:
    """Return the condition on a figure; 'source/name' selects one of several of a name."""
    source, _, parameter = name.rpartition("/")
    named = or_(
        FIGURES.c.name == name, and_(FIGURES.c.source == source, FIGURES.c.name == parameter)
    )
    same_unit = FIGURES.c.unit == si_symbol(value_range.dimension)
    return named, same_unit, _within(FIGURES.c.value, value_range)


def _result_conditions(filters: Filters) -> list[ColumnElement[bool]]:
    """Return the conditions on a result of each given name; on one of any name if none is given."""
    by_name: list[ColumnElement[bool]] = []
    for name, value_range in filters.results.items():
        conditions = [RESULTS.c.name == name]
        if value_range is not None:
            conditions.append(RESULTS.c.si_unit == si_symbol(value_range.dimension))
            conditions.append(_within(RESULTS.c.si_value, value_range))
        by_name.append(and_(*conditions))
    return by_name or [true()]


def _coordinate_conditions(filters: Filters) -> list[ColumnElement[bool]]:
    """Return the conditions on the coordinates of a result."""
    of_result = (COORDINATES.c.run == RESULTS.c.run, COORDINATES.c.number == RESULTS.c.number)
    return [
        exists().where(*of_result, _coordinate(name, value))
        for name, value in filters.where.items()
    ]


def _coordinate(name: str, value: Quantity | str) -> ColumnElement[bool]:
    """Return whether a coordinate is the given one; for a bare number, in any unit."""
    same_name = or_(COORDINATES.c.name == name, COORDINATES.c.short == name)
    if isinstance(value, str):
        return and_(same_name, COORDINATES.c.text == value)
    if value.dimension == "ratio" and value.unit.symbol == "1":
        shown = CoordinateValue(value.number)
    else:
        shown = CoordinateValue.of_si(value.si, si_symbol(value.dimension))
        same_name = and_(same_name, COORDINATES.c.unit == shown.unit)
    center = float(shown.value)
    near = SAME * max(abs(center), SAME)
    return and_(same_name, COORDINATES.c.value.between(center - near, center + near))


def _within(column: ColumnElement[Any], value_range: Range) -> ColumnElement[bool]:
    return column.between(value_range.low, value_range.high)


def _text(column: ColumnElement[Any], pattern: str, dialect: Dialect) -> ColumnElement[bool]:
    """Match a text, or a pattern with '*' and '?'; case matters."""
    if column.name == "verdict" and pattern == NONE:
        return column.is_(None)
    if not any(sign in pattern for sign in "*?"):
        return column == pattern
    if dialect.name == "sqlite":  # its LIKE takes upper and lower case as the same
        begin = re.split(r"[*?]", pattern, maxsplit=1)[0]
        matching = column.op("GLOB", is_comparison=True)(pattern.replace("[", "[[]"))
        return and_(column.between(begin, f"{begin}{_LAST}"), matching)  # so an index can be used
    for sign, escaped in ((_ESCAPE, _ESCAPE * 2), ("%", r"\%"), ("_", r"\_")):
        pattern = pattern.replace(sign, escaped)
    return column.like(pattern.replace("*", "%").replace("?", "_"), escape=_ESCAPE)


def _is_copy() -> ColumnElement[bool]:
    """Return whether the same recordings exist under another path, which counts instead."""
    other = RUNS.alias("other")
    first = or_(
        and_(~other.c.missing, RUNS.c.missing),
        and_(other.c.missing == RUNS.c.missing, other.c.id < RUNS.c.id),
    )
    same = and_(other.c.run_id == RUNS.c.run_id, other.c.digest_sha256 == RUNS.c.digest_sha256)
    return exists().where(same, first)
