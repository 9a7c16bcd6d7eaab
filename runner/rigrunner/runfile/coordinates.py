"""Coordinates in a run file: a group for a recording, columns for the rows of a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from rigrunner.api.coordinates import coordinate_text
from rigrunner.api.units import from_si
from rigrunner.runfile.hdf5 import free_name, new_group, write_ascii

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    import h5py

    from rigrunner.api.coordinates import Coordinate
    from rigrunner.api.data import Measurement

_GROUP = "coordinates"


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
    if _GROUP not in parent:
        return {}, {}
    members = {str(each.attrs["name"]): each.attrs for each in parent[_GROUP].values()}
    # h5py gives numbers as numpy's own, and texts.
    found = {name: each["value"] for name, each in members.items()}
    values = {
        name: cast("Coordinate", each.item() if isinstance(each, np.generic) else str(each))
        for name, each in found.items()
    }
    units = {name: str(each["units"]) for name, each in members.items() if "units" in each}
    return values, units


def write_written(parent: h5py.Group, written_in: Mapping[str, str]) -> None:
    """Write the number and unit of each set-point and coordinate as in the procedure."""
    for member in _kept(parent):
        if symbol := written_in.get(str(member.attrs["name"])):
            # A coordinate is a group with attributes, a set-point a scalar dataset.
            value = member.attrs["value"] if "value" in member.attrs else member[()]
            number = from_si(float(value), symbol)
            member.attrs.update({"written": number, "written_in": symbol})


def write_written_columns(table: h5py.Group, rows: Sequence[Measurement]) -> None:
    """Write the unit of each column as in the procedure, and its numbers in that unit as `written`.

    None if the rows of a column have several units: the events have them.
    """
    for member in _kept(table):
        name = str(member.attrs["name"])
        there = [
            one
            for one in rows
            if name in one.setpoints or name in one.coordinates or name in one.values
        ]
        written = {one.written_in.get(name, "") for one in there}
        if len(written) == 1 and (symbol := written.pop()):
            numbers = [from_si(float(each), symbol) for each in member[()]]
            member.attrs.update({"written": np.array(numbers), "written_in": symbol})


def read_written(parent: h5py.Group) -> dict[str, str]:
    """Read the units of set-points and coordinates in the procedure, by name."""
    return {
        str(member.attrs["name"]): str(member.attrs["written_in"])
        for member in _kept(parent)
        if "written_in" in member.attrs
    }


def _kept(parent: h5py.Group) -> Iterator[h5py.Group | h5py.Dataset]:
    for group in ("setpoints", _GROUP, "values"):
        if group in parent:
            yield from parent[group].values()


def write_coordinate_columns(table: h5py.Group, rows: Sequence[Measurement]) -> None:
    """Write a column for each coordinate of the rows of a table, if they have any.

    A counter or number that a row lacks is not-a-number; truth values are the texts yes and no.
    """
    names = dict.fromkeys(name for one in rows for name in one.coordinates)
    if not names:
        return
    group = new_group(table, _GROUP, "NXcollection")
    units = {name: unit for one in rows for name, unit in one.units.items()}
    for name in names:
        column = [one.coordinates.get(name) for one in rows]
        place = free_name(group, name)
        values = [each for each in column if each is not None]
        if all(isinstance(each, int | float) and not isinstance(each, bool) for each in values):
            group[place] = np.array([np.nan if each is None else each for each in column])
        else:
            texts = ["" if each is None else coordinate_text(each) for each in column]
            write_ascii(group, place, texts)
        group[place].attrs.update({"name": name, "units": units.get(name, "")})
