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
    known: dict[str, Any] = {
        "name": measurement.name,
        "setpoints": dict(measurement.setpoints),
        "units": dict(measurement.units),
        "values": dict(measurement.values),
    }
    if version >= FIRST_WITH_LIMITS:
        known["limits"] = msgspec.to_builtins(measurement.limits)
        known["recording"] = measurement.recording
    if measurement.coordinates:  # a row of before has none, and the same digest as before
        known["coordinates"] = dict(measurement.coordinates)
    if measurement.readings:
        known["readings"] = dict(measurement.readings)
        known["expected"] = msgspec.to_builtins(measurement.expected)
    text = _canonical(known)
    return hashlib.sha256(text.encode()).hexdigest()


def write_measurements(
    entry: h5py.Group, measurements: Sequence[Measurement], group: str = "measurements"
) -> None:
    """Write a table for each name: a column for each set-point and channel, one row each time.

    Further columns have the rest of a row: coordinates, time, cycles, recording.
    """
    tables = new_group(entry, group, "NXcollection")
    for name in dict.fromkeys(one.name for one in measurements):
        rows = [one for one in measurements if one.name == name]
        table = new_group(tables, free_name(tables, name), "NXdata")
        table.attrs["name"] = name
        write_ascii(table, "utc", [one.utc for one in rows])
        if any(one.elapsed_s is not None for one in rows):
            table["elapsed"] = _bounds(one.elapsed_s for one in rows)
            table["elapsed"].attrs["units"] = "s"
        if any(one.cycles is not None for one in rows):
            table["cycles"] = _bounds(one.cycles for one in rows)
        write_coordinate_columns(table, rows)
        _write_columns(table, "setpoints", [one.setpoints for one in rows], rows)
        _write_columns(table, "values", [one.values for one in rows], rows)
        write_written_columns(table, rows)
        if any(one.readings for one in rows):
            _write_readings(table, rows)
        if any(one.recording for one in rows):
            write_ascii(table, "recording", [one.recording for one in rows])
        if any(one.limits or one.expected for one in rows):
            _write_limits(table, rows)


def _write_limits(table: h5py.Group, rows: Sequence[Measurement]) -> None:
    """Write the limits of each limited value, and whether it is within them, one row each time.

    A missing bound is not-a-number; `passes` is 1, 0, or -1 for a row without limits.
    """
    group = new_group(table, "limits", "NXcollection")
    units = {member: unit for one in rows for member, unit in one.units.items()}
    passes = np.ones(len(rows), np.uint8)
    columns: dict[str, tuple[Array, Array, Array]] = {}
    for at, row in enumerate(rows):
        for name, (limits, within) in _decided(row).items():
            if name not in columns:
                columns[name] = (*np.full((2, len(rows)), np.nan), np.full(len(rows), -1, np.int8))
            for column, cell in zip(
                columns[name], (limits.lower, limits.upper, within), strict=True
            ):
                column[at] = cell
            passes[at] &= within
    for name, (lowest, highest, each) in columns.items():
        one = new_group(group, free_name(group, name), "NXcollection")
        one.attrs.update({"name": str(name), "units": units.get(name, "")})
        one["minimum"], one["maximum"], one["passes"] = _bounds(lowest), _bounds(highest), each
    table["passes"] = passes


def _decided(row: Measurement) -> dict[str, tuple[Limits, bool]]:
    """Return by name the limits of a row and whether its values are within them.

    These are its `decisions` without their reasons.
    """
    found = {
        each.of: (each.limits, each.limits.allow(row.values[each.of]))
        for each in row.limits
        if each.of in row.values
    }
    if not row.expected:
        return found
    of_readings = (each for each in row.decisions if each.of not in found)
    return found | {each.of: (each.limits, each.passes) for each in of_readings}


def _bounds(bounds: Iterable[float | None]) -> Array:
    found = np.array([np.nan if each is None else each for each in bounds], np.float64)
    return np.where(np.isinf(found), np.nan, found)


def _write_columns(
    table: h5py.Group, name: str, cells: Sequence[Mapping[str, float]], rows: Sequence[Measurement]
) -> None:
    """Write columns that some rows may lack; there they are not-a-number."""
    group = new_group(table, name, "NXcollection")
    units = {member: unit for one in rows for member, unit in one.units.items()}
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
    units = {member: unit for one in rows for member, unit in one.units.items()}
    for member in dict.fromkeys(_names([one.readings for one in rows])):
        column, place = [one.readings.get(member) for one in rows], free_name(group, member)
        lengths = {len(each) for each in column if isinstance(each, tuple)}
        if len(lengths) == 1:
            empty = (np.nan,) * lengths.pop()
            group[place] = np.array([empty if each is None else each for each in column])
        else:
            write_ascii(group, place, ["" if each is None else _text(each) for each in column])
        group[place].attrs.update({"name": str(member), "units": units.get(member, "")})


def _text(value: Reading) -> str:
    return " ".join(map(repr, value)) if isinstance(value, tuple) else reading_text(value)


def _names(cells: Iterable[Mapping[str, object]]) -> Iterator[str]:
    for cell in cells:
        yield from cell
