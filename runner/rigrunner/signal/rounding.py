"""How many decimals to show for a number (GUM 7.2.6), and texts with as many."""

from __future__ import annotations

from math import floor, isclose, isfinite, log10, nan
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

PLACES_WITHOUT_UNCERTAINTY = 4
LEAST_PLACES: Mapping[str, int] = {"N·m": 4}
"""Decimals of a margin at least, by the SI units in which 0.1.0 stated all values of their kind.

Documents of that version are compared with those of today.
"""
UNKNOWN = "-"
"""In place of a missing estimate."""


def places(uncertainty: float, digits: int = 2) -> int:
    """Return how many decimals show an uncertainty with so many significant digits.

    Negative for uncertainties of tens and more; four where there is none to go by.
    """
    if not (isfinite(uncertainty) and uncertainty > 0):
        return PLACES_WITHOUT_UNCERTAINTY
    # Rounded first: 0.0996 has the place of the 0.10 as which it is printed.
    rounded = float(f"{uncertainty:.{digits - 1}e}")
    return digits - 1 - floor(log10(rounded))


def places_of_margin(decimals: int, unit: str) -> int:
    """Return how many decimals a margin or a difference has, from those of U with two digits.

    In a unit of LEAST_PLACES so many, or as many as show one digit of a smaller U.
    """
    least = LEAST_PLACES.get(unit)
    return decimals if least is None else max(least, decimals - 1)


def places_apart(first: float, second: float, decimals: int) -> int:
    """Return the fewest decimals, so many at least, with which two numbers are printed unlike.

    Of two that differ by less than rounding: so many.
    """
    if isclose(first, second, rel_tol=1e-14):
        return decimals
    digits = decimals
    while printed(first, digits) == printed(second, digits):
        digits += 1
    return digits


def with_uncertainty(value: float, expanded: float) -> str:
    """Return 'value ± U', U with two significant digits and the value to the same place.

    This is the rounding of GUM 7.2.6. An uncertainty that is zero or not finite is shown as it is.
    """
    if not (isfinite(expanded) and expanded > 0):
        return f"{value:.4g} ± {expanded:.2g}"
    decimals = places(expanded)
    return f"{printed(value, decimals)} ± {printed(expanded, decimals)}"


def printed(value: float, decimals: int) -> str:
    """Return a number with that many decimals (negative: rounded to tens, hundreds, ...)."""
    text = f"{round(value, decimals):.{max(decimals, 0)}f}"
    # -0.003 to two decimals is 0.00, and not -0.00.
    return text.removeprefix("-") if float(text) == 0 else text


def estimate_text(estimate: Mapping[str, Any] | None) -> str:
    """Return 'value ± U' of an estimate of a result document."""
    if estimate is None or estimate["value"] is None:
        return UNKNOWN
    expanded = estimate["expanded_uncertainty_95"]
    return with_uncertainty(estimate["value"], nan if expanded is None else expanded)
