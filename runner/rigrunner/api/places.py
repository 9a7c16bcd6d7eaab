"""Places select one of several values by set-points and coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from math import isclose
from typing import TYPE_CHECKING, Annotated

from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema

from rigrunner.api.quantity import Quantity, parse_quantity
from rigrunner.api.texts import plain
from rigrunner.api.units import QuantityError, unit

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.coordinates import CoordinateValue

SAME = 1e-6
"""Relative tolerance of a coordinate."""
_COORDINATE = "[A-Za-z][A-Za-z0-9_]*([.][A-Za-z][A-Za-z0-9_]*)?"


def _read(value: object) -> object:
    if isinstance(value, Quantity):
        return value
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise QuantityError("expected a number with its unit, a count, or a text")
    if isinstance(value, (int, float)):
        return Quantity(float(value), unit("1"))
    try:
        return parse_quantity(value)
    except QuantityError:
        # It begins as a number, so it is a mistyped quantity rather than a text.
        if value[:1].isdigit() or value[:1] in "+-.":
            raise
        return plain(value)


_SCHEMA = {"anyOf": [{"type": "string"}, {"type": "number"}]}
PlaceValue = Annotated[Quantity | str, BeforeValidator(_read), WithJsonSchema(_SCHEMA)]
"""Value of a coordinate: a quantity, '2 A', a count, 3, or a text, 'final'."""
CoordinateKey = Annotated[str, Field(pattern=f"^{_COORDINATE}$")]
"""A drive, 'role.name', or the name of a counter or label."""
Place = Annotated[Mapping[CoordinateKey, PlaceValue], AfterValidator(dict)]
"""A value for some coordinates: {load.current: 2 A, phase: final}."""


def _read_several(value: object) -> object:
    if isinstance(value, list | tuple):
        if not value:
            raise QuantityError("got an empty list, expected one value or several")
        return tuple(map(_read, value))
    return (_read(value),)


PlaceValues = Annotated[
    tuple[Quantity | str, ...],
    BeforeValidator(_read_several),
    WithJsonSchema({"anyOf": [*_SCHEMA["anyOf"], {"type": "array", "items": _SCHEMA}]}),
]
"""One value of a coordinate, or several: 2 A, [1 A, 2 A]."""
Places = Annotated[Mapping[CoordinateKey, PlaceValues], AfterValidator(dict)]
"""One value or several for some coordinates: {load.current: [1 A, 2 A]}."""


def each_of(places: Mapping[str, tuple[Quantity | str, ...]]) -> Iterator[Place]:
    """Yield each place, with one value per coordinate; for none a single empty place."""
    for values in product(*places.values()):
        yield dict(zip(places, values, strict=True))


def is_in(
    places: Mapping[str, tuple[Quantity | str, ...]], coordinates: Mapping[str, CoordinateValue]
) -> bool:
    """Return whether coordinates are at one of the places."""
    return any(is_at(place, coordinates) for place in each_of(places))


def places_text(places: Mapping[str, tuple[Quantity | str, ...]]) -> str:
    """Return places as text, equal for equal places: 'load.current = 1 A or 2 A'."""
    return ", ".join(
        f"{name} = {' or '.join(sorted(map(str, values)))}"
        for name, values in sorted(places.items())
    )


def matches(expected: Quantity | str, actual: CoordinateValue) -> bool:
    """Return whether a coordinate has a value; quantities in any unit of one kind."""
    if isinstance(expected, str) or isinstance(actual.value, str):
        return expected == actual.value
    actual_unit = unit(actual.unit or "1")
    if expected.dimension != actual_unit.dimension:
        return False
    # A share of the number as written: of 293 K it would be too coarse for a value in °C. The
    # relative tolerance below is for 0 °C, where the conversion to K rounds.
    size = SAME * max(abs(expected.number * expected.unit.factor), 1e-9)
    return isclose(expected.si, actual_unit.to_si(actual.value), rel_tol=SAME * 1e-3, abs_tol=size)


def is_at(place: Mapping[str, Quantity | str], coordinates: Mapping[str, CoordinateValue]) -> bool:
    """Return whether coordinates are at a place; other coordinates can have any value."""
    return all(
        name in coordinates and matches(value, coordinates[name]) for name, value in place.items()
    )
