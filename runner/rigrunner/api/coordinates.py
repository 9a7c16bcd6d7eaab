"""Coordinates: what tells a recording or a row of a table from others, beside its set-points.

A counter of a `repeat` is an integer. The value of a label is a text, a boolean or a float: a
number, or a quantity in SI units, whose unit stands among the units of its recording or row.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isclose
from typing import TYPE_CHECKING, Any, Protocol

from rigrunner.api.quantity import Quantity
from rigrunner.api.units import from_si, si_symbol, unit

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

Coordinate = bool | int | float | str


DIGITS = 6
"""Significant digits of a coordinate in texts; files have all."""


@dataclass(frozen=True)
class CoordinateValue:
    """Where a result holds, in one respect: a number with its unit, or a text without one."""

    value: float | str
    unit: str = ""
    """Of the number, as shown: the one in which a person wrote it."""

    @classmethod
    def of_si(cls, value: float | str, si_unit: str = "", written_in: str = "") -> CoordinateValue:
        """Return the coordinate of an SI value as it is written; or of a label.

        Where it is not known how it is written: in SI units, temperatures in °C.
        """
        if isinstance(value, bool):
            return cls("yes" if value else "no")
        if isinstance(value, str) or not si_unit:
            return cls(value)
        known, shown = unit(si_unit), unit(written_in or usual_unit(si_unit))
        number = (value * known.factor + known.offset - shown.offset) / shown.factor
        return cls(float(f"{number:.12g}"), shown.symbol)

    @classmethod
    def stored(cls, found: object) -> CoordinateValue:
        """Return the coordinate that a result document has: a number with its unit, or a text."""
        number = found.get("value") if isinstance(found, Mapping) else None
        if isinstance(found, Mapping) and isinstance(number, int | float):
            return cls(float(number), str(found.get("unit") or ""))
        return cls(str(found))

    @property
    def usual(self) -> CoordinateValue:
        """The same in the unit that values have where nobody wrote one: equal for equal values."""
        if isinstance(self.value, str) or not self.unit:
            return self
        found = self.in_unit(usual_unit(si_symbol(unit(self.unit).dimension)))
        return CoordinateValue(float(f"{found.value:.10g}"), found.unit)

    def in_unit(self, symbol: str) -> CoordinateValue:
        """Return the number in another unit of its kind; a text stays as it is."""
        if isinstance(self.value, str) or self.unit == symbol:
            return self
        known, shown = unit(self.unit or "1"), unit(symbol or "1")
        si = self.value * known.factor + known.offset
        return CoordinateValue(float(f"{(si - shown.offset) / shown.factor:.12g}"), symbol)

    def __str__(self) -> str:
        """Return it in words: '2 A', 'final'."""
        if isinstance(self.value, str):
            return self.value
        number = f"{self.value:.{DIGITS}g}"
        return number if self.unit in {"", "1"} else f"{number} {self.unit}"


def usual_unit(si_unit: str) -> str:
    """Return the unit in which a value is shown where nobody wrote one: °C for K."""
    return "°C" if unit(si_unit).dimension == "temperature" else si_unit


def is_told(written_in: str, si_unit: str) -> bool:
    """Say whether a unit as written has to be kept beside the SI unit to be shown again."""
    return bool(written_in) and not written_in == si_unit == usual_unit(si_unit)


def place_text(coordinates: Mapping[str, CoordinateValue]) -> str:
    """Return where a result holds, in words: 'load.current = 2 A'; '' for the only one."""
    return ", ".join(f"{name} = {each}" for name, each in coordinates.items())


class Placed(Protocol):
    """What has set-points and coordinates: a recording, a row of a table."""

    @property
    def setpoints(self) -> Mapping[str, float]:
        """Each in the SI unit."""
        ...

    @property
    def coordinates(self) -> Mapping[str, Coordinate]:
        """Counters and labels, by name."""
        ...

    @property
    def written_in(self) -> Mapping[str, str]:
        """The units in which the procedure writes them, where that is not SI."""
        ...


class Read(Protocol):
    """What has values that were read: a row of a table."""

    @property
    def values(self) -> Mapping[str, float]:
        """By channel, each in the SI unit."""
        ...

    @property
    def written_in(self) -> Mapping[str, str]:
        """The units in which people see them, where that is not SI."""
        ...


def labels_of(coordinates: Mapping[str, Coordinate]) -> dict[str, Coordinate]:
    """Return the coordinates that say what differs: all but counters, which count the same."""
    return {
        name: value
        for name, value in coordinates.items()
        if isinstance(value, bool) or not isinstance(value, int)
    }


def coordinate_text(value: Coordinate, unit: str = "") -> str:
    """Return the value of a coordinate in words: '3', 'wear', 'yes', '60 s'."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    number = f"{value:.6g}"
    return f"{number} {unit}" if unit and unit != "1" else number


def coordinates_text(
    coordinates: Mapping[str, Coordinate],
    units: Mapping[str, str],
    written_in: Mapping[str, str] | None = None,
) -> str:
    """Return coordinates in words: 'phase wear, dwell 60 s, block 3'; in units as written."""
    return ", ".join(
        f"{name} {written_text(value, units.get(name, ''), (written_in or {}).get(name, ''))}"
        for name, value in coordinates.items()
    )


def written_text(value: Coordinate, unit: str = "", written_in: str = "") -> str:
    """Return a set-point or coordinate in words, in the unit in which it is written."""
    if not written_in or isinstance(value, bool | str):
        return coordinate_text(value, unit)
    return coordinate_text(from_si(value, written_in), written_in)


def number_text(value: Coordinate, written_in: str = "") -> str:
    """Return a set-point or coordinate without its unit, as a table has it."""
    if not written_in or isinstance(value, bool | str):
        return coordinate_text(value)
    return coordinate_text(from_si(value, written_in))


def written_column(rows: Sequence[Placed], name: str, unit: str) -> tuple[str, list[str]]:
    """Return the unit of a column of set-points or of a coordinate, and its cells, as written.

    Where rows write it in several units each cell has its own, and the column none.
    """
    values = [row.coordinates.get(name, row.setpoints.get(name, "")) for row in rows]
    return _column(values, [row.written_in.get(name, "") for row in rows], unit)


def measured_column(rows: Sequence[Read], name: str, unit: str) -> tuple[str, list[str]]:
    """Return the unit of a column of measured values, and its cells, '' of one without a value.

    In the unit in which the channel is declared, or its set-point is written.
    """
    values = [row.values.get(name, "") for row in rows]
    return _column(values, [row.written_in.get(name, "") for row in rows], unit)


def _column(values: Sequence[Coordinate], units: Sequence[str], unit: str) -> tuple[str, list[str]]:
    written = {each for each, value in zip(units, values, strict=True) if value != ""}
    if len(written) == 1:
        (one,) = written
        return one or unit, [number_text(value, one) for value in values]
    return "", [written_text(value, unit, each) for value, each in zip(values, units, strict=True)]


def matches(coordinates: Mapping[str, Coordinate], where: Mapping[str, Any]) -> bool:
    """Say whether coordinates have the values of a selection, of Labels as a file has them."""
    return all(
        name in coordinates and _is_same(coordinates[name], in_si(wanted)[0])
        for name, wanted in where.items()
    )


def mixed_labels(
    found: Iterable[tuple[Mapping[str, float], Mapping[str, Coordinate], Mapping[str, str]]],
) -> str:
    """Return the labels, in words, by which things with the same set-points differ; '' for none.

    Each of `found` is set-points, coordinates and units. Counters do not matter: they count the
    same thing.
    """
    seen: dict[tuple[object, ...], str] = {}
    for setpoints, coordinates, units in found:
        text = coordinates_text(labels_of(coordinates), units) or "no label"
        first = seen.setdefault(tuple(sorted(setpoints.items())), text)
        if first != text:
            return f"{first}; {text}"
    return ""


def _is_same(value: Coordinate, wanted: Coordinate) -> bool:
    if isinstance(value, bool | str) or isinstance(wanted, bool | str):
        return type(value) is type(wanted) and value == wanted
    return isclose(value, wanted, rel_tol=1e-9)


def with_unit(name: str, unit: str) -> str:
    """Return the head of a column of coordinates: 'phase', 'dwell / s'."""
    return f"{name} / {unit}" if unit and unit != "1" else name


def in_si(value: Quantity | Coordinate) -> tuple[Coordinate, str]:
    """Return the value of a label as it is stored, and its unit; '' where it has none."""
    if isinstance(value, Quantity):
        return value.si, si_symbol(value.dimension)
    return value, ""
