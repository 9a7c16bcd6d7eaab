"""Parse limits of a quantity."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError
from rigrunner.api.quantity import parse_quantity
from rigrunner.api.units import QuantityError, from_si, unit, with_article

if TYPE_CHECKING:
    from rigrunner.api.quantity import Quantity


def limit_in(text: str, symbol: str) -> float | None:
    """Return a limit in the unit of a study, None for an empty text; raise UsageError."""
    return from_si(_read(text, symbol).si, symbol) if text else None


def width_in(text: str, symbol: str) -> float | None:
    """Return a difference of two limits in the unit of a study; raises as `limit_in`."""
    if not text:
        return None
    found = _read(text, symbol)
    # A difference: the offset of a scale of temperature is in none.
    return found.number * found.unit.factor / unit(symbol).factor


def _read(text: str, symbol: str) -> Quantity:
    try:
        found = parse_quantity(text)
    except QuantityError as error:
        raise UsageError(f"'{text}': {error.message}", hint=error.hint) from error
    if found.dimension != unit(symbol).dimension:
        raise UsageError(
            f"'{text}' is {with_article(found.dimension)}, and the values are in {symbol}"
        )
    return found
