"""Numbers of studies, with the decimals that their scatter justifies."""

from __future__ import annotations

from rigrunner.signal.rounding import places
from rigrunner_reports.numbers import fixed


def as_scattered(value: float, deviation: float) -> str:
    """Return a value with one decimal more than its standard deviation justifies."""
    return fixed(value, max(0, places(deviation) + 1))


def percent(part: float, of: float) -> str:
    """Return a fraction in percent."""
    return fixed(100.0 * part / of, 1)
