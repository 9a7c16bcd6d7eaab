"""Quantities with units: parsed once on input, SI inside, formatted on output.

Ambiguous numbers are refused: '1,5 N' is not read as 15 N.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError
from rigrunner.api.texts import clip
from rigrunner.api.unit_tables import FACTORS, Unit
from rigrunner.api.units import (
    COMPOSED,
    QuantityError,
    find_unit,
    from_si,
    spellings_of,
    unit,
    units_of,
    usual_units,
    with_article,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

_MINUS = "\N{MINUS SIGN}"
LONGEST_S = 3653 * 86400.0
"""Ten years, the longest duration."""
_LARGEST = {"time": LONGEST_S, "frequency": 1e12}
_LARGEST_OF_ANY = 1e18
"""In SI units. Larger numbers are typing mistakes."""

NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_QUANTITY = re.compile(rf"({NUMBER})\s*(.*)", re.DOTALL)
_MORE_DIGITS = re.compile(r"[.,:'_]?[0-9]")
_LITERAL = str.maketrans({sign: rf"\{sign}" for sign in "$^.*+?()[]{}|/\\"})
_INVERSE = re.compile(r"1(?:/|$)")
_COMMA = re.compile(r"[+-]?[0-9]+,([0-9]+)(?![0-9,.])")
_GROUP = 3  # digits after a comma that may as well separate thousands
_LEGIBLE = 1000  # and more: the next prefix fits better


def quantity_pattern(dimension: str | None = None) -> str:
    """Return a regular expression, also valid in JSON Schema, for the input of `parse_quantity`.

    It does not check the magnitude, nor the kind of a product or quotient of units.
    """
    spellings = "\n".join(spellings_of(dimension)).translate(_LITERAL).replace("\n", "|")
    # After a number, a digit can only begin the unit 1 or 1/..., and only after a space.
    number = NUMBER.replace("[+-]", f"[+{_MINUS}-]")
    return rf"^\s*{number}(?:(?![0-9.])\s*|\s+(?=1))(?:{spellings}|{COMPOSED})\s*$"


@dataclass(frozen=True)
class Estimate:
    """A measured value with its standard uncertainty and degrees of freedom (GUM 2.3.1, G.3)."""

    value: float
    u: float
    dof: float = float("inf")
    unit: str = "N·m"
    kurtosis: float = 0.0
    """Excess kurtosis from bounded inputs; negative: flatter than a normal distribution."""


@dataclass(frozen=True)
class Quantity:
    """A value with its unit as written, and its SI value for computations."""

    number: float
    unit: Unit

    @property
    def si(self) -> float:
        """The value in the SI unit of its kind (rad, N·m, Hz, K, ...)."""
        return self.unit.to_si(self.number)

    @property
    def dimension(self) -> str:
        """The kind of quantity, such as 'force'."""
        return self.unit.dimension

    def __str__(self) -> str:
        """Return the quantity as text; parsing it gives the same quantity."""
        return f"{repr(self.number).removesuffix('.0')} {self.unit.symbol}"


def largest(dimension: str) -> float:
    """Return the largest accepted amount of a kind, in its SI unit."""
    return _LARGEST.get(dimension, _LARGEST_OF_ANY)


def readable(si: float, dimension: str) -> Quantity:
    """Return an SI value as the quantity with the fewest characters, such as 45 mm.

    A ratio is given in %, since '1 1' is hard to understand.
    """
    units = [u for u in usual_units(dimension) if u.symbol != "1"]
    quantities = [Quantity(float(f"{u.from_si(si):.12g}"), u) for u in units]
    # Of a unit without offset, 12 digits are always within this: there is one at least.
    exact = [quantity for quantity in quantities if math.isclose(quantity.si, si, rel_tol=1e-11)]
    return min(exact, key=lambda quantity: len(str(quantity)))


def legible(si: float, symbol: str) -> str:
    """Return an SI value as text, in a smaller or larger unit where its number has an exponent.

    '450 nm' of 4.5e-07 in 'm'; 24.5 in 'N' stays '24.5 N'. A temperature, not a difference, is in
    °C, as people write it.
    """
    if symbol == "K":
        return f"{from_si(si, '°C'):.6g} °C"
    text = f"{si:.6g}"
    if symbol and "e" in text:
        for candidate in usual_and_prefixed(symbol):
            number = candidate.from_si(si)
            if 1 <= abs(number) < _LEGIBLE:
                return f"{number:.6g} {candidate.symbol}"
    return f"{text} {symbol}".rstrip()


def usual_and_prefixed(symbol: str) -> Iterator[Unit]:
    """Yield the usual units of the kind of an SI unit, and this unit with prefixes."""
    dimension = unit(symbol).dimension
    yield from usual_units(dimension)
    for prefix in FACTORS:
        # kg has a prefix already; not every unit takes every prefix; pH is no picohenry.
        prefixed = find_unit(prefix + ("g" if symbol == "kg" else symbol))
        if prefixed and prefixed.dimension == dimension:
            yield prefixed


def parse_quantity(text: str, dimension: str | None = None) -> Quantity:
    """Parse '1.5 kN' and the like; raise QuantityError for anything ambiguous.

    Refused: a missing unit, a unit of another kind, a decimal comma, grouped digits, inf and nan.
    """
    stripped, quoted = text.strip().replace(_MINUS, "-"), f"'{clip(text)}'"
    match = _QUANTITY.fullmatch(stripped)
    if match is None:
        raise QuantityError(f"{quoted} is not a number with a unit", hint=_example(dimension))
    if not match[2]:
        raise QuantityError(f"{quoted} has no unit", hint=_example(dimension))
    if match[2].startswith("/"):
        raise QuantityError(f"{quoted} has no number before its unit", hint=_example(dimension))
    if _MORE_DIGITS.match(match[2]) and not _INVERSE.match(match[2]):
        raise _marked_digits(stripped)
    quantity = Quantity(float(match[1]), unit(match[2], dimension))
    if dimension is not None and quantity.dimension != dimension:
        kinds = f"{with_article(quantity.dimension)}, not {with_article(dimension)}"
        raise QuantityError(f"{quoted} is {kinds}", hint=_example(dimension))
    limit = largest(quantity.dimension)
    if not abs(quantity.si) <= limit:
        raise QuantityError(
            f"{quoted} is too large",
            hint=f"at most {readable(limit, quantity.dimension)}",
        )
    return quantity


def entered_si(what: str, text: str, dimension: str) -> float:
    """Return the SI value of what a person entered; raise UsageError that names what it is for."""
    try:
        return parse_quantity(text, dimension).si
    except QuantityError as error:
        raise UsageError(f"{what}: {error.message}", hint=error.hint) from error


def _marked_digits(text: str) -> QuantityError:
    """Return the refusal of '1,5 N', '1,000 N' and '1 000 N', which can mean two numbers."""
    comma = _COMMA.match(text)
    if comma is None:
        hint = "write digits without spaces or marks between them, such as '1000.5 N'"
        return QuantityError(f"'{clip(text)}' has more than one number", hint=hint)
    as_point = f"'{clip(text.replace(',', '.', 1))}'"
    as_group = f" or '{clip(text.replace(',', '', 1))}'" if len(comma[1]) == _GROUP else ""
    return QuantityError(f"'{clip(text)}' has a decimal comma", hint=f"write {as_point}{as_group}")


def _example(dimension: str | None) -> str:
    return (
        f"units of {dimension}: {', '.join(units_of(dimension))}"
        if dimension
        else "such as '10 Hz'"
    )
