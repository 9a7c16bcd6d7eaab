"""Parse ranges of values and times: '0.5..0.8 N·m', '10 Hz', '2026-01-31'."""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta
from math import inf

from rigrunner.api.errors import UsageError
from rigrunner.api.quantity import Quantity, parse_quantity
from rigrunner.api.units import QuantityError, unit

_BARE = re.compile(r"[+-]?[0-9.]+(?:[eE][+-]?[0-9]+)?")
_EXAMPLES = "such as '0.5..0.8 N·m', '..0.8 N·m' or '0.5 N·m..'"
_NOMINAL = 1e-6
"""Relative tolerance of a nominal value."""
_DAY = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2}")
_RESOLUTION = timedelta(milliseconds=1)
"""Resolution of the times in run files."""


@dataclass(frozen=True)
class Range:
    """Values from `low` to `high`, both included, in the SI unit of their dimension."""

    low: float
    high: float
    dimension: str


def range_of(text: str, dimension: str | None = None, *, nominal: bool = False) -> Range:
    """Parse 'LOW..HIGH UNIT', with either end left out or with a unit of its own.

    With `nominal`, a single value is accepted too. Raises UsageError.
    """
    written = text.strip().replace("\N{MINUS SIGN}", "-")
    low, dots, high = written.partition("..")
    if not dots:
        return _nominal(text, written, dimension, nominal=nominal)
    if high.startswith(".") or ".." in high or not (low.strip() or high.strip()):
        raise _no_range(text)
    low, high = _with_units(low.strip(), high.strip())
    first, last = _end(low, text, dimension), _end(high, text, dimension)
    dimension = next(end[1] for end in (first, last) if end is not None)
    if first is not None and last is not None and first[1] != last[1]:
        raise UsageError(f"'{text}' combines a {first[1]} with a {last[1]}")
    result = Range(-inf if first is None else first[0], inf if last is None else last[0], dimension)
    if result.low > result.high:
        raise UsageError(f"'{text}' is empty", hint="the smaller value comes first")
    return result


def place_of(text: str) -> Quantity | str:
    """Parse the value of a coordinate: '100 °C', a bare number '3', or a text such as 'final'.

    A bare number has the unit '1'. Raises UsageError.
    """
    written = text.strip().replace("\N{MINUS SIGN}", "-")
    if _BARE.fullmatch(written):
        return Quantity(float(written), unit("1"))
    try:
        return parse_quantity(written)
    except QuantityError as error:
        if written[:1].isdigit() or written[:1] in {"+", "-", "."}:
            raise UsageError(f"'{text}': {error.message}", hint=error.hint) from error
        return written


def since(text: str) -> datetime:
    """Return the beginning of a day, or a time; UTC without a zone."""
    return _moment(text)


def until(text: str) -> datetime:
    """Return the time before which something must be: the end of that day, or that time."""
    step = timedelta(days=1) if _DAY.fullmatch(text.strip()) else _RESOLUTION
    try:
        return _moment(text) + step
    except OverflowError as error:
        raise UsageError(f"'{text}' is later than any run") from error


def _moment(text: str) -> datetime:
    try:
        if _DAY.fullmatch(text.strip()):
            day = date.fromisoformat(text.strip())
            return datetime(day.year, day.month, day.day, tzinfo=UTC)
        time = datetime.fromisoformat(text.strip())
        return time.astimezone(UTC) if time.tzinfo else time.replace(tzinfo=UTC)
    except (ValueError, OverflowError) as error:
        raise UsageError(
            f"'{text}' is not a date or time",
            hint="such as 2026-01-31, or 2026-01-31T13:30+01:00; UTC where no zone is given",
        ) from error


def _nominal(text: str, written: str, dimension: str | None, *, nominal: bool) -> Range:
    if not nominal:
        raise _no_range(text)
    end = _end(written, text, dimension)
    assert end is not None  # noqa: S101  (only an empty end is None, and then there were dots)
    value, dimension = end
    near = abs(value) * _NOMINAL
    return Range(value - near, value + near, dimension)


def _with_units(low: str, high: str) -> tuple[str, str]:
    """Give an end without a unit the unit of the other."""
    if _BARE.fullmatch(low):
        low += _unit_of(high)
    elif _BARE.fullmatch(high):
        high += _unit_of(low)
    return low, high


def _unit_of(text: str) -> str:
    number = _BARE.match(text)
    return text[number.end() :] if number else ""


def _end(end: str, text: str, dimension: str | None) -> tuple[float, str] | None:
    if not end:
        return None
    try:
        quantity = parse_quantity(end, dimension)
    except QuantityError as error:
        raise UsageError(f"'{text}': {error.message}", hint=error.hint or _EXAMPLES) from error
    return quantity.si, quantity.dimension


def _no_range(text: str) -> UsageError:
    return UsageError(f"'{text}' is not a range", hint=_EXAMPLES)
