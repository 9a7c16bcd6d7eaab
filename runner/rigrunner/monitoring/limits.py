"""Limits of a quantity as a person writes them."""

from __future__ import annotations

from rigrunner.api.errors import UsageError
from rigrunner.api.quantity import parse_quantity
from rigrunner.api.units import QuantityError, si_symbol


def limit_in(text: str, unit: str) -> float | None:
    """Return a limit in the SI unit of a study, None for an empty text; raise UsageError."""
    if not text:
        return None
    try:
        found = parse_quantity(text)
    except QuantityError as error:
        raise UsageError(f"'{text}': {error.message}", hint=error.hint) from error
    if si_symbol(found.dimension) != unit:
        raise UsageError(f"'{text}' is a {found.dimension}, and the values are in {unit}")
    return found.si
