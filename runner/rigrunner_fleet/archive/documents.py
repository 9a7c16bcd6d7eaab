"""Read values from a result document of any origin; None for a value of the wrong type."""

from __future__ import annotations

import re
from datetime import UTC, datetime
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

from rigrunner.runfile.scan import storable

if TYPE_CHECKING:
    from collections.abc import Iterator

LONGEST_KEY = 600
"""In characters: the index of PostgreSQL has room for 2,704 bytes per row."""
_INFINITE = "infinite"
"""How a document writes infinite degrees of freedom."""


def at(document: object, *keys: str) -> Any:
    """Return the value under nested keys; None if there is none."""
    for key in keys:
        document = document.get(key) if isinstance(document, dict) else None
    return document


def number(value: object) -> float | None:
    """Return a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        result = float(value)
    except OverflowError:
        return None
    return result if isfinite(result) else None


def degrees_of_freedom(value: object) -> float | None:
    """Return degrees of freedom, which may be infinite."""
    return inf if value == _INFINITE else number(value)


def text(value: object) -> str | None:
    """Return a text that databases accept."""
    return storable(value) if isinstance(value, str) else None


def key(value: object) -> str | None:
    """Return a text for an indexed column, shortened to the limit of the index."""
    string = text(value)
    if string and len(string) > LONGEST_KEY:
        return f"{string[: LONGEST_KEY - 1]}…"
    return string


def digest(value: object) -> str | None:
    """Return a digest in hexadecimal digits; an older run has an empty one."""
    string = text(value)
    return None if string is None or not re.fullmatch("([0-9a-f]{2})*", string) else string


def count(value: object) -> int | None:
    """Return a whole number that is small enough for a column."""
    fits = isinstance(value, int) and not isinstance(value, bool) and abs(value) < 1 << 31
    return value if fits and isinstance(value, int) else None


def rows(value: object) -> Iterator[dict[str, Any]]:
    """Yield the mappings of a list."""
    for entry in value if isinstance(value, list) else ():
        if isinstance(entry, dict):
            yield entry


def mappings(value: object) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the mappings of a mapping, with their names."""
    for name, entry in value.items() if isinstance(value, dict) else ():
        if isinstance(entry, dict):
            yield storable(str(name)), entry


def moment(value: object) -> datetime | None:
    """Return an ISO 8601 time with its zone; UTC if it has none."""
    try:
        time = datetime.fromisoformat(value if isinstance(value, str) else "")
        return time.astimezone(UTC) if time.tzinfo else time.replace(tzinfo=UTC)
    except (ValueError, OverflowError):
        return None
