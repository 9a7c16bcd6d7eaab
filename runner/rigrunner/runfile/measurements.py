"""Single values of a run: what tells them from others, and how they are tables for viewers."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.runfile.hdf5 import free_name, new_group, write_ascii

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    import h5py

    from rigrunner.api.data import Measurement


def measurement_digest(measurement: Measurement) -> str:
    """Return the SHA-256 of a measurement as JSON (keys sorted, no spaces), without its time."""
    known = {
        "name": measurement.name,
        "setpoints": dict(measurement.setpoints),
        "units": dict(measurement.units),
        "values": dict(measurement.values),
    }
    text = json.dumps(known, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def write_measurements(entry: h5py.Group, measurements: Sequence[Measurement]) -> None:
    """Write a table for each name: a column for each set-point and channel, a row each time."""
    tables = new_group(entry, "measurements", "NXcollection")
    for name in dict.fromkeys(one.name for one in measurements):
        rows = [one for one in measurements if one.name == name]
        table = new_group(tables, free_name(tables, name), "NXdata")
        table.attrs["name"] = name
        write_ascii(table, "utc", [one.utc for one in rows])
        _write_columns(table, "setpoints", [one.setpoints for one in rows], rows)
        _write_columns(table, "values", [one.values for one in rows], rows)


def _write_columns(
    table: h5py.Group, name: str, cells: Sequence[Mapping[str, float]], rows: Sequence[Measurement]
) -> None:
    """Write what some of the rows may lack as not-a-number."""
    group = new_group(table, name, "NXcollection")
    units = {member: unit for one in rows for member, unit in one.units.items()}
    for member in dict.fromkeys(_names(cells)):
        column = np.array([cell.get(member, np.nan) for cell in cells])
        dataset = group.create_dataset(free_name(group, member), data=column)
        dataset.attrs.update({"name": member, "units": units.get(member, "")})


def _names(cells: Iterable[Mapping[str, float]]) -> Iterator[str]:
    for cell in cells:
        yield from cell
