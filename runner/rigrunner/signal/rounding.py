"""How many decimals a number deserves (GUM 7.2.6)."""

from __future__ import annotations

from math import floor, isfinite, log10

PLACES_WITHOUT_UNCERTAINTY = 4


def places(uncertainty: float, digits: int = 2) -> int:
    """Return how many decimals show an uncertainty with so many significant digits.

    Negative for uncertainties of tens and more; four where there is none to go by.
    """
    if not (isfinite(uncertainty) and uncertainty > 0):
        return PLACES_WITHOUT_UNCERTAINTY
    rounded = float(f"{uncertainty:.{digits - 1}e}")
    return digits - 1 - floor(log10(rounded))
