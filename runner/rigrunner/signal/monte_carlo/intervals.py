"""Coverage intervals from the values that a Monte Carlo method drew (JCGM 101:2008, 7.7)."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, log10
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rigrunner.api.data import Array


@dataclass(frozen=True)
class Interval:
    """A coverage interval."""

    low: float
    high: float


def symmetric(ordered: Array, p: float) -> Interval:
    """Return the probabilistically symmetric interval of ordered values, shape (n,) (7.7.2)."""
    count = _count(len(ordered), p)
    first = (len(ordered) - count) // 2
    return Interval(float(ordered[first]), float(ordered[first + count]))


def shortest(ordered: Array, p: float) -> Interval:
    """Return the shortest interval of ordered values, shape (n,) (7.7.3)."""
    count = _count(len(ordered), p)
    first = int(np.argmin(ordered[count:] - ordered[:-count]))
    return Interval(float(ordered[first]), float(ordered[first + count]))


def _count(n: int, p: float) -> int:
    """Return over how many steps of the ordered values an interval reaches."""
    return min(round(p * n), n - 1)


def numerical_tolerance(u: float, digits: int) -> float:
    """Return half of the last of the digits that matter in a standard uncertainty (7.9.2)."""
    if u <= 0:
        return 0.0
    exponent = floor(log10(float(f"{u:.{digits - 1}e}"))) - (digits - 1)
    return 0.5 * 10.0**exponent
