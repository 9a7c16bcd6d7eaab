"""Coordinates in a run file: a group for a recording, columns for the rows of a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import h5py
import numpy as np

from rigrunner.api.coordinates import coordinate_text
from rigrunner.api.units import from_si
from rigrunner.runfile.hdf5 import free_name, new_group, write_ascii

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.coordinates import Coordinate
    from rigrunner.api.data import Measurement

_GROUP = "coordinates"
_WRITTEN = ("setpoints", _GROUP, "values")
"""Groups with members that may have a unit of the procedure."""


def write_coordinates(
    parent: h5py.Group, coordinates: Mapping[str, Coordinate], units: Mapping[str, str]
) -> None:
    """Write a member for each, with the attributes `name`, `value` and, if it has one, `units`.

    A counter is an int64, a number a float64, a truth value a boolean, a text a text.
    """
    group = new_group(parent, _GROUP, "NXcollection")
    for name, value in coordinates.items():
        member = new_group(group, free_name(group, name), "NXcollection")
        member.attrs.update({"name": name, "value": value})
        if name in units:
            member.attrs["units"] = units[name]


def read_coordinates(parent: h5py.Group) -> tuple[dict[str, Coordinate], dict[str, str]]:
    """Read coordinates and their units. Runs of earlier versions have none."""
    attributes = {str(member.attrs["name"]): member.attrs for member in _members(parent, _GROUP)}
    # h5py gives numbers as numpy's own, and texts.
    stored = {name: attrs["value"] for name, attrs in attributes.items()}
    values = {
        name: cast("Coordinate", value.item() if isinstance(value, np.generic) else str(value))
        for name, value in stored.items()
    }
    units = {name: str(attrs["units"]) for name, attrs in attributes.items() if "units" in attrs}
    return values, units


def write_written(parent: h5py.Group, written_in: Mapping[str, str]) -> None:
    """Write the number and unit of each set-point and coordinate as in the procedure."""
    for member in _members(parent, *_WRITTEN):
        if symbol := written_in.get(str(member.attrs["name"])):
            # A coordinate is a group with attributes, a set-point a scalar dataset.
            value = member.attrs["value"] if "value" in member.attrs else member[()]
            number = from_si(float(value), symbol)
            member.attrs.update({"written": number, "written_in": symbol})


def write_written_columns(table: h5py.Group, rows: Sequence[Measurement]) -> None:
    """Write the unit of each column as in the procedure, and its numbers in that unit as `written`.

    None if the rows of a column have several units: the events have them.
    """
    for member in _members(table, *_WRITTEN):
        name = str(member.attrs["name"])
        rows_with_it = [
            row
            for row in rows
            if name in row.setpoints or name in row.coordinates or name in row.values
        ]
        written = {row.written_in.get(name, "") for row in rows_with_it}
        if len(written) == 1 and (symbol := written.pop()):
            numbers = [from_si(float(number), symbol) for number in member[()]]
            member.attrs.update({"written": np.array(numbers), "written_in": symbol})


def read_written(parent: h5py.Group) -> dict[str, str]:
    """Read the units of set-points and coordinates in the procedure, by name."""
    return {
        str(member.attrs["name"]): str(member.attrs["written_in"])
        for member in _members(parent, *_WRITTEN)
        if "written_in" in member.attrs
    }


def _members(parent: h5py.Group, *groups: str) -> Iterator[h5py.Group | h5py.Dataset]:
    for name in groups:
        # A channel may have such a name: it is a dataset.
        if isinstance(group := parent.get(name), h5py.Group):
            yield from group.values()


def write_coordinate_columns(table: h5py.Group, rows: Sequence[Measurement]) -> None:
    """Write a column for each coordinate of the rows of a table, if they have any.

    A counter or number that a row lacks is not-a-number; truth values are the texts yes and no.
    """
    names = dict.fromkeys(name for row in rows for name in row.coordinates)
    if not names:
        return
    group = new_group(table, _GROUP, "NXcollection")
    units = {name: unit for row in rows for name, unit in row.units.items()}
    for name in names:
        column = [row.coordinates.get(name) for row in rows]
        key = free_name(group, name)
        values = [value for value in column if value is not None]
        if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
            group[key] = np.array([np.nan if value is None else value for value in column])
        else:
            texts = ["" if value is None else coordinate_text(value) for value in column]
            write_ascii(group, key, texts)
        group[key].attrs.update({"name": name, "units": units.get(name, "")})
