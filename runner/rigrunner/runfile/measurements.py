"""Single values of a run: their digest, and their tables for viewers."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from rigrunner.api.readings import reading_text
from rigrunner.runfile.coordinates import write_coordinate_columns, write_written_columns
from rigrunner.runfile.hdf5 import free_name, new_group, write_ascii

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    import h5py

    from rigrunner.api.data import Array, Measurement
    from rigrunner.api.readings import Reading
    from rigrunner.api.verdict import Limits


_canonical = json.JSONEncoder(sort_keys=True, separators=(",", ":")).encode
FIRST_WITH_LIMITS = 3
"""The first version of the layout in which rows have limits, which their digest covers."""


def measurement_digest(measurement: Measurement, version: int) -> str:
    """Return the SHA-256 of a measurement as JSON (keys sorted, no spaces), without its time.

    The algorithm depends on the version of the layout. It is never changed for a released version,
    since each stored run would get another identity.
    """
    document: dict[str, Any] = {
        "name": measurement.name,
        "setpoints": dict(measurement.setpoints),
        "units": dict(measurement.units),
        "values": dict(measurement.values),
    }
    if version >= FIRST_WITH_LIMITS:
        document["limits"] = msgspec.to_builtins(measurement.limits)
        document["recording"] = measurement.recording
    if measurement.coordinates:  # a row of before has none, and the same digest as before
        document["coordinates"] = dict(measurement.coordinates)
    if measurement.readings:
        document["readings"] = dict(measurement.readings)
        document["expected"] = msgspec.to_builtins(measurement.expected)
    text = _canonical(document)
    return hashlib.sha256(text.encode()).hexdigest()


def write_measurements(
    entry: h5py.Group, measurements: Sequence[Measurement], group: str = "measurements"
) -> None:
    """Write a table for each name: a column for each set-point and channel, one row each time.

    Further columns have the rest of a row: coordinates, time, cycles, recording.
    """
    tables = new_group(entry, group, "NXcollection")
    for name in dict.fromkeys(row.name for row in measurements):
        rows = [row for row in measurements if row.name == name]
        table = new_group(tables, free_name(tables, name), "NXdata")
        table.attrs["name"] = name
        write_ascii(table, "utc", [row.utc for row in rows])
        if any(row.elapsed_s is not None for row in rows):
            table["elapsed"] = _bounds(row.elapsed_s for row in rows)
            table["elapsed"].attrs["units"] = "s"
        if any(row.cycles is not None for row in rows):
            table["cycles"] = _bounds(row.cycles for row in rows)
        write_coordinate_columns(table, rows)
        _write_columns(table, "setpoints", [row.setpoints for row in rows], rows)
        _write_columns(table, "values", [row.values for row in rows], rows)
        write_written_columns(table, rows)
        if any(row.readings for row in rows):
            _write_readings(table, rows)
        if any(row.recording for row in rows):
            write_ascii(table, "recording", [row.recording for row in rows])
        if any(row.limits or row.expected for row in rows):
            _write_limits(table, rows)


def _write_limits(table: h5py.Group, rows: Sequence[Measurement]) -> None:
    """Write the limits of each limited value, and whether it is within them, one row each time.

    A missing bound is not-a-number; `passes` is 1, 0, or -1 for a row without limits.
    """
    group = new_group(table, "limits", "NXcollection")
    units = {member: unit for row in rows for member, unit in row.units.items()}
    passes = np.ones(len(rows), np.uint8)
    columns: dict[str, tuple[Array, Array, Array]] = {}
    for index, row in enumerate(rows):
        for name, (limits, within) in _decisions(row).items():
            if name not in columns:
                columns[name] = (*np.full((2, len(rows)), np.nan), np.full(len(rows), -1, np.int8))
            for column, cell in zip(
                columns[name], (limits.lower, limits.upper, within), strict=True
            ):
                column[index] = cell
            passes[index] &= within
    for name, (lowest, highest, column_passes) in columns.items():
        limit = new_group(group, free_name(group, name), "NXcollection")
        limit.attrs.update({"name": str(name), "units": units.get(name, "")})
        limit["minimum"], limit["maximum"] = _bounds(lowest), _bounds(highest)
        limit["passes"] = column_passes
    table["passes"] = passes


def _decisions(row: Measurement) -> dict[str, tuple[Limits, bool]]:
    """Return by name the limits of a row and whether its values are within them.

    These are its `decisions` without their reasons.
    """
    decisions = {
        limit.of: (limit.limits, limit.limits.allow(row.values[limit.of]))
        for limit in row.limits
        if limit.of in row.values
    }
    if not row.expected:
        return decisions
    of_readings = (decision for decision in row.decisions if decision.of not in decisions)
    return decisions | {reading.of: (reading.limits, reading.passes) for reading in of_readings}


def _bounds(bounds: Iterable[float | None]) -> Array:
    values = np.array([np.nan if bound is None else bound for bound in bounds], np.float64)
    return np.where(np.isinf(values), np.nan, values)


def _write_columns(
    table: h5py.Group, name: str, cells: Sequence[Mapping[str, float]], rows: Sequence[Measurement]
) -> None:
    """Write columns that some rows may lack; there they are not-a-number."""
    group = new_group(table, name, "NXcollection")
    units = {member: unit for row in rows for member, unit in row.units.items()}
    for member in dict.fromkeys(_names(cells)):
        column = np.array([cell.get(member, np.nan) for cell in cells])
        dataset = group.create_dataset(free_name(group, member), data=column)
        dataset.attrs.update({"name": str(member), "units": units.get(member, "")})


def _write_readings(table: h5py.Group, rows: Sequence[Measurement]) -> None:
    """Write a column for each reading that is not a number.

    Arrays of one length become a table of float64, one row each time, with not-a-number for a
    missing one. Arrays of several lengths, texts and truth values become texts, empty for a missing
    one.
    """
    group = new_group(table, "readings", "NXcollection")
    units = {member: unit for row in rows for member, unit in row.units.items()}
    for member in dict.fromkeys(_names([row.readings for row in rows])):
        column, key = [row.readings.get(member) for row in rows], free_name(group, member)
        lengths = {len(value) for value in column if isinstance(value, tuple)}
        if len(lengths) == 1:
            empty = (np.nan,) * lengths.pop()
            group[key] = np.array([empty if value is None else value for value in column])
        else:
            write_ascii(group, key, ["" if value is None else _text(value) for value in column])
        group[key].attrs.update({"name": str(member), "units": units.get(member, "")})


def _text(value: Reading) -> str:
    return " ".join(map(repr, value)) if isinstance(value, tuple) else reading_text(value)


def _names(cells: Iterable[Mapping[str, object]]) -> Iterator[str]:
    for cell in cells:
        yield from cell
