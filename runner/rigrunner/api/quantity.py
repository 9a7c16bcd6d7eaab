"""Quantities with units: parsed once at the edge, SI inside, printed at the edge.

A small fixed table of accepted spellings instead of a units library: a general parser reads
'12.3 Nm' as twelve point three nano-metres or yarn counts, and '1,5 N' as 15 N.
"""

from __future__ import annotations

import difflib
import math
import re
from dataclasses import dataclass

from rigrunner.api.errors import RigrunnerError


@dataclass(frozen=True)
class Unit:
    """A unit of measurement; SI value = number * factor + offset."""

    symbol: str
    dimension: str
    factor: float = 1.0
    offset: float = 0.0


_DEG = math.pi / 180
_MINUS = "\N{MINUS SIGN}"

UNITS: tuple[Unit, ...] = (
    Unit("N·m", "torque"),
    Unit("mN·m", "torque", 1e-3),
    Unit("in·lbf", "torque", 0.1129848290276167),
    Unit("N", "force"),
    Unit("kN", "force", 1e3),
    Unit("Hz", "frequency"),
    Unit("kHz", "frequency", 1e3),
    Unit("rpm", "frequency", 1 / 60),
    Unit("rad", "angle"),
    Unit("mrad", "angle", 1e-3),
    Unit("deg", "angle", _DEG),
    Unit("s", "time"),
    Unit("ms", "time", 1e-3),
    Unit("min", "time", 60.0),
    Unit("h", "time", 3600.0),
    Unit("d", "time", 86400.0),
    Unit("m", "length"),
    Unit("mm", "length", 1e-3),
    Unit("µm", "length", 1e-6),
    Unit("1", "ratio"),
    Unit("%", "ratio", 1e-2),
    Unit("K", "temperature"),
    Unit("°C", "temperature", 1.0, 273.15),
    Unit("V", "voltage"),
    Unit("mV", "voltage", 1e-3),
    Unit("mV/V", "voltage ratio", 1e-3),
    Unit("A", "current"),
    Unit("mA", "current", 1e-3),
    Unit("kg", "mass"),
    Unit("g", "mass", 1e-3),
    Unit("kg·m²", "moment of inertia"),
    Unit("N·m·s/rad", "rotational damping"),
    Unit("rad/s", "angular velocity"),
    Unit("deg/s", "angular velocity", _DEG),
    Unit("rad/s²", "angular acceleration"),
    Unit("N/s", "force rate", 1.0),
    Unit("kN/s", "force rate", 1e3),
    Unit("Hz/s", "frequency rate", 1.0),
    Unit("rpm/s", "frequency rate", 1 / 60),
    Unit("m/s", "speed"),
    Unit("mm/s", "speed", 1e-3),
    Unit("N·m/s", "torque rate"),
    Unit("K/s", "temperature rate"),
    Unit("K/min", "temperature rate", 1 / 60),
)

LONGEST_S = 3653 * 86400.0
"""Ten years: no duration, and no procedure, is longer."""
_LARGEST = {"time": LONGEST_S, "frequency": 1e12}
_LARGEST_OF_ANY = 1e18
"""In SI units. What is larger is a slip of the pen, and no step could wait for it or reach it."""

_SPELLINGS = {
    "N.m": "N·m", "Nm": "N·m", "N*m": "N·m", "N m": "N·m",
    "mN.m": "mN·m", "mNm": "mN·m", "mN*m": "mN·m",
    "in-lb": "in·lbf", "in.lbf": "in·lbf", "in-lbf": "in·lbf",
    "°": "deg", "um": "µm", "μm": "µm", "degC": "°C", "kg.m2": "kg·m²", "kg·m2": "kg·m²",
    "kg.m^2": "kg·m²", "kg m2": "kg·m²", "N.m.s/rad": "N·m·s/rad", "rad/s2": "rad/s²",
    "r/min": "rpm",
}  # fmt: skip

_BY_SYMBOL = {unit.symbol: unit for unit in UNITS}
_BY_SPELLING = _BY_SYMBOL | {
    spelling: _BY_SYMBOL[symbol] for spelling, symbol in _SPELLINGS.items()
}
_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_QUANTITY = re.compile(rf"({_NUMBER})\s*(.*)", re.DOTALL)
_MORE_DIGITS = re.compile(r"[.,:'_]?[0-9]")
_COMMA = re.compile(r"[+-]?[0-9]+,([0-9]+)(?![0-9,.])")
_GROUP = 3
_LONGEST = 40
_NEAR = 0.51
"""How alike a unit must be to be suggested: °C is not what was meant by °F."""


class QuantityError(RigrunnerError, ValueError):
    """A text is not a quantity of the kind that is needed here."""


def unit(symbol: str, dimension: str | None = None) -> Unit:
    """Return the unit of that symbol or spelling; raise QuantityError with a suggestion.

    `dimension`: what is measured here; a unit of something else is not suggested.
    """
    wanted = symbol.strip()
    known = _BY_SPELLING.get(wanted)
    if known is not None:
        return known
    by_case = {
        spelling.lower(): found.symbol
        for spelling, found in _BY_SPELLING.items()
        if dimension in (None, found.dimension)
    }
    near = difflib.get_close_matches(wanted[:_LONGEST].lower(), by_case, n=1, cutoff=_NEAR)
    all_of_them = _example(dimension) if dimension else f"known units: {_listing()}"
    hint = f"did you mean '{by_case[near[0]]}'?" if near else all_of_them
    raise QuantityError(f"unknown unit '{_clip(wanted)}'", hint=hint)


def units_of(dimension: str) -> list[str]:
    """Return the symbols of all units of that dimension."""
    return [known.symbol for known in UNITS if known.dimension == dimension]


def quantity_pattern(dimension: str | None = None) -> str:
    """Return a regular expression, for JSON Schema too, of what `parse_quantity` reads.

    It does not know of numbers that are too large to be meant.
    """
    spellings = [
        re.sub(r"([$^.*+?()\[\]{}|/\\])", r"\\\1", spelling)
        for spelling, known in _BY_SPELLING.items()
        if dimension in (None, known.dimension)
    ]
    number = _NUMBER.replace("[+-]", f"[+{_MINUS}-]")
    return rf"^\s*{number}(?![0-9.])\s*(?:{'|'.join(spellings)})\s*$"


@dataclass(frozen=True)
class Quantity:
    """A value with its unit as a person wrote it, and its SI value for computing."""

    number: float
    unit: Unit

    @property
    def si(self) -> float:
        """The value in the SI unit of its dimension (rad, N·m, Hz, K, ...)."""
        return self.number * self.unit.factor + self.unit.offset

    @property
    def dimension(self) -> str:
        """The name of the quantity's dimension, such as 'torque'."""
        return self.unit.dimension

    def __str__(self) -> str:
        """Return the quantity as a file may have it; reading that gives the same quantity."""
        return f"{repr(self.number).removesuffix('.0')} {self.unit.symbol}"


def largest(dimension: str) -> float:
    """Return the largest amount of a dimension that is read, in its SI unit."""
    return _LARGEST.get(dimension, _LARGEST_OF_ANY)


def readable(si: float, dimension: str) -> Quantity:
    """Return an SI value as the quantity that takes the fewest characters, such as 45 mm.

    A ratio is given in %: '1 1' is read, but not understood.
    """
    units = [known for known in UNITS if known.dimension == dimension and known.symbol != "1"]
    written = [
        Quantity(float(f"{(si - known.offset) / known.factor:.12g}"), known) for known in units
    ]
    exact = [each for each in written if math.isclose(each.si, si, rel_tol=1e-11)]
    return min(exact, key=lambda quantity: len(str(quantity)))


def parse_quantity(text: str, dimension: str | None = None) -> Quantity:
    """Read '1.5 kN' and the like; raise QuantityError for anything a person might regret.

    Refused: a missing unit, a unit of another dimension, a decimal comma, digits in groups, inf and
    nan.
    """
    stripped, shown = text.strip().replace(_MINUS, "-"), f"'{_clip(text)}'"
    match = _QUANTITY.fullmatch(stripped)
    if match is None:
        raise QuantityError(f"{shown} is not a number with a unit", hint=_example(dimension))
    if not match[2]:
        raise QuantityError(f"{shown} has no unit", hint=_example(dimension))
    if _MORE_DIGITS.match(match[2]) and match[2] not in _BY_SPELLING:
        raise _marked_digits(stripped)
    quantity = Quantity(float(match[1]), unit(match[2], dimension))
    if dimension is not None and quantity.dimension != dimension:
        kinds = f"{_with_article(quantity.dimension)}, not {_with_article(dimension)}"
        raise QuantityError(f"{shown} is {kinds}", hint=_example(dimension))
    most = largest(quantity.dimension)
    if not abs(quantity.si) <= most:
        raise QuantityError(
            f"{shown} is too large to be meant",
            hint=f"at most {readable(most, quantity.dimension)}",
        )
    return quantity


def _marked_digits(text: str) -> QuantityError:
    """Return the refusal of '1,5 N', '1,000 N' and '1 000 N', of which one may mean two numbers."""
    comma = _COMMA.match(text)
    if comma is None:
        hint = "write digits without spaces or marks between them, such as '1000.5 N'"
        return QuantityError(f"'{_clip(text)}' has more than one number", hint=hint)
    as_point = f"'{_clip(text.replace(',', '.', 1))}'"
    as_group = f" or '{_clip(text.replace(',', '', 1))}'" if len(comma[1]) == _GROUP else ""
    return QuantityError(f"'{_clip(text)}' has a decimal comma", hint=f"write {as_point}{as_group}")


def si_symbol(dimension: str) -> str:
    """Return the symbol of the coherent SI unit of a dimension."""
    return next(
        u.symbol for u in UNITS if u.dimension == dimension and (u.factor, u.offset) == (1, 0)
    )


def _example(dimension: str | None) -> str:
    return (
        f"units of {dimension}: {', '.join(units_of(dimension))}"
        if dimension
        else "such as '10 Hz'"
    )


def _with_article(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _clip(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


def _listing() -> str:
    return ", ".join(known.symbol for known in UNITS)
