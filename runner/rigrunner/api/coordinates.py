"""Coordinates, which distinguish recordings or rows of a table in addition to set-points.

A counter of a `repeat` is an integer. The value of a label is a text, a boolean or a float: a
number, or a quantity in SI units, whose unit is one of the units of its recording or row.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isclose
from typing import TYPE_CHECKING, Any, Protocol

from rigrunner.api.quantity import Quantity
from rigrunner.api.units import from_si, si_symbol, unit, with_symbol

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

Coordinate = bool | int | float | str


DIGITS = 6
"""Significant digits of a coordinate in texts; files have all."""


@dataclass(frozen=True)
class CoordinateValue:
    """A coordinate of a result: a number with its unit, or a text without one."""

    value: float | str
    unit: str = ""
    """Unit of the number as displayed, which is the one in the procedure."""

    @classmethod
    def of_si(cls, value: float | str, si_unit: str = "", written_in: str = "") -> CoordinateValue:
        """Return the coordinate of an SI value as written in the procedure; or of a label.

        Unknown units are SI, temperatures °C.
        """
        if isinstance(value, bool):
            return cls("yes" if value else "no")
        if isinstance(value, str) or not si_unit:
            return cls(value)
        target = unit(written_in or usual_unit(si_unit))
        number = target.from_si(unit(si_unit).to_si(value))
        # 12 digits: without what the conversion adds in the last ones, 70 °F is 70 again.
        return cls(float(f"{number:.12g}"), target.symbol)

    @classmethod
    def stored(cls, document: object) -> CoordinateValue:
        """Return a coordinate from a result document: a number with its unit, or a text."""
        number = document.get("value") if isinstance(document, Mapping) else None
        if isinstance(document, Mapping) and isinstance(number, int | float):
            return cls(float(number), str(document.get("unit") or ""))
        return cls(str(document))

    @property
    def usual(self) -> CoordinateValue:
        """The coordinate in the usual unit: equal for equal values."""
        if isinstance(self.value, str) or not self.unit:
            return self
        usual = self.in_unit(usual_unit(si_symbol(unit(self.unit).dimension)))
        # Fewer digits than a conversion keeps: one value written in two units is equal then.
        return CoordinateValue(float(f"{usual.value:.10g}"), usual.unit)

    def in_unit(self, symbol: str) -> CoordinateValue:
        """Return the number in another unit of its kind; a text stays as it is."""
        if isinstance(self.value, str) or self.unit == symbol:
            return self
        number = unit(symbol or "1").from_si(unit(self.unit or "1").to_si(self.value))
        return CoordinateValue(float(f"{number:.12g}"), symbol)

    def __str__(self) -> str:
        """Return it as text: '2 A', 'final'."""
        if isinstance(self.value, str):
            return self.value
        return with_symbol(f"{self.value:.{DIGITS}g}", self.unit)


def usual_unit(si_unit: str) -> str:
    """Return the unit for values that no file states: °C for K."""
    return "°C" if unit(si_unit).dimension == "temperature" else si_unit


def has_display_unit(written_in: str, si_unit: str) -> bool:
    """Return whether the unit as written must be stored beside the SI unit."""
    # K is an SI unit, but not the usual one: unless stored, a temperature would be shown in °C.
    return bool(written_in) and not written_in == si_unit == usual_unit(si_unit)


def place_text(coordinates: Mapping[str, CoordinateValue]) -> str:
    """Return the place of a result as text: 'load.current = 2 A'; '' for the only one."""
    return ", ".join(f"{name} = {value}" for name, value in coordinates.items())


class Placed(Protocol):
    """Has set-points and coordinates: a recording, a row of a table."""

    @property
    def setpoints(self) -> Mapping[str, float]:
        """Set-points in SI units."""
        ...

    @property
    def coordinates(self) -> Mapping[str, Coordinate]:
        """Counters and labels, by name."""
        ...

    @property
    def written_in(self) -> Mapping[str, str]:
        """Units in the procedure, if not SI."""
        ...


class Read(Protocol):
    """Has values that were read: a row of a table."""

    @property
    def values(self) -> Mapping[str, float]:
        """Values by channel, in SI units."""
        ...

    @property
    def written_in(self) -> Mapping[str, str]:
        """Units for display, if not SI."""
        ...


def labels_of(coordinates: Mapping[str, Coordinate]) -> dict[str, Coordinate]:
    """Return the coordinates without counters."""
    return {
        name: value
        for name, value in coordinates.items()
        # A bool is an int too, but a label.
        if isinstance(value, bool) or not isinstance(value, int)
    }


def coordinate_text(value: Coordinate, unit: str = "") -> str:
    """Return the value of a coordinate as text: '3', 'wear', 'yes', '60 s'."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    return with_symbol(f"{value:.{DIGITS}g}", unit)


def coordinates_text(
    coordinates: Mapping[str, Coordinate],
    units: Mapping[str, str],
    written_in: Mapping[str, str] | None = None,
) -> str:
    """Return coordinates as text: 'phase wear, dwell 60 s, block 3'; in units as written."""
    return ", ".join(
        f"{name} {written_text(value, units.get(name, ''), (written_in or {}).get(name, ''))}"
        for name, value in coordinates.items()
    )


def written_text(value: Coordinate, unit: str = "", written_in: str = "") -> str:
    """Return a set-point or coordinate as text, in the unit as written."""
    if not written_in or isinstance(value, bool | str):
        return coordinate_text(value, unit)
    return coordinate_text(from_si(value, written_in), written_in)


def number_text(value: Coordinate, written_in: str = "") -> str:
    """Return a set-point or coordinate without its unit, for a table."""
    if not written_in or isinstance(value, bool | str):
        return coordinate_text(value)
    return coordinate_text(from_si(value, written_in))


def written_column(rows: Sequence[Placed], name: str, unit: str) -> tuple[str, list[str]]:
    """Return the unit and the cells of a column of set-points or of a coordinate, as written.

    If the units of the rows differ, each cell has its own and the column none.
    """
    values = [row.coordinates.get(name, row.setpoints.get(name, "")) for row in rows]
    return _column(values, [row.written_in.get(name, "") for row in rows], unit)


def measured_column(rows: Sequence[Read], name: str, unit: str) -> tuple[str, list[str]]:
    """Return the unit and the cells of a column of measured values; '' for no value.

    In the unit declared for the channel, or of its set-point as written. Values of one unit have
    equal decimals.
    """
    values = [row.values.get(name, "") for row in rows]
    head, cells = _column(values, [row.written_in.get(name, "") for row in rows], unit)
    return head, _with_equal_decimals(cells) if head else cells


def _with_equal_decimals(cells: list[str]) -> list[str]:
    """Return numbers with the decimals of the one that has most, if none gets too many digits."""
    decimals = max((len(cell.partition(".")[2]) for cell in cells), default=0)
    padded = [_padded(cell, decimals) if cell and decimals else cell for cell in cells]
    digits = [cell.replace(".", "").lstrip("-0") for cell in padded]
    are_few = all(not text or (text.isdigit() and len(text) <= DIGITS) for text in digits)
    return padded if are_few else cells


def _padded(number: str, decimals: int) -> str:
    integer, _, part = number.partition(".")
    return f"{integer}.{part:0<{decimals}}"


def _column(values: Sequence[Coordinate], units: Sequence[str], unit: str) -> tuple[str, list[str]]:
    symbols = {symbol for symbol, value in zip(units, values, strict=True) if value != ""}
    if len(symbols) == 1:
        (symbol,) = symbols
        return symbol or unit, [number_text(value, symbol) for value in values]
    return "", [written_text(value, unit, each) for value, each in zip(values, units, strict=True)]


def matches(coordinates: Mapping[str, Coordinate], where: Mapping[str, Any]) -> bool:
    """Return whether coordinates have the values of a selection, which are Labels of a file."""
    return all(
        name in coordinates and _is_same(coordinates[name], in_si(selected)[0])
        for name, selected in where.items()
    )


def mixed_labels(
    items: Iterable[tuple[Mapping[str, float], Mapping[str, Coordinate], Mapping[str, str]]],
) -> str:
    """Return the labels, as text, by which items with equal set-points differ; '' for none.

    Each item has set-points, coordinates and units. Counters are ignored, since they number
    repetitions.
    """
    seen: dict[tuple[object, ...], str] = {}
    for setpoints, coordinates, units in items:
        text = coordinates_text(labels_of(coordinates), units) or "no label"
        first = seen.setdefault(tuple(sorted(setpoints.items())), text)
        if first != text:
            return f"{first}; {text}"
    return ""


def _is_same(value: Coordinate, selected: Coordinate) -> bool:
    if isinstance(value, bool | str) or isinstance(selected, bool | str):
        return type(value) is type(selected) and value == selected
    return isclose(value, selected, rel_tol=1e-9)


def with_unit(name: str, unit: str) -> str:
    """Return the head of a column of coordinates: 'phase', 'dwell / s'."""
    return f"{name} / {unit}" if unit and unit != "1" else name


def in_si(value: Quantity | Coordinate) -> tuple[Coordinate, str]:
    """Return the value of a label as stored, and its unit; '' for none."""
    if isinstance(value, Quantity):
        return value.si, si_symbol(value.dimension)
    return value, ""
