"""Numbers in text files, with a decimal point or a decimal comma."""

from __future__ import annotations

import math


def number(cell: str, decimal: str) -> float | None:
    """Return the number in a cell; None where it is none, is not finite, or has the other mark."""
    text = cell.strip()
    other = "," if decimal == "." else "."
    # Python's float would take 1_000 for a number.
    if other in text or "_" in text:
        return None
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        return None
    return value if math.isfinite(value) else None
