"""Coverage intervals from the values that a Monte Carlo method drew (JCGM 101:2008, 7.7)."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, log10
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.data import Array


@dataclass(frozen=True)
class Interval:
    """A coverage interval."""

    low: float
    high: float


def ranked(values: Array, p: float) -> Array:
    """Return the values, shape (n,), with those in place that the intervals take by their rank.

    The least and the greatest are in order, those between them are not. numpy finds one rank at a
    time several times as fast as four together, or than it orders all, as processors differ.
    """
    least = _tail(len(values), p)
    between = len(values) - 2 * least
    if between <= 0:
        return np.sort(values)
    partitioned = np.partition(values, least)
    partitioned[:least].sort()
    upper = partitioned[least:]
    upper.partition(between)
    upper[between:].sort()
    return partitioned


def symmetric(ordered: Array, p: float) -> Interval:
    """Return the probabilistically symmetric interval of ordered or ranked values (7.7.2)."""
    count = _count(len(ordered), p)
    first = (len(ordered) - count) // 2
    return Interval(float(ordered[first]), float(ordered[first + count]))


class Intervals(NamedTuple):
    """Both intervals of the same values."""

    symmetric: Interval
    shortest: Interval


def intervals(blocks: Sequence[Array], p: float) -> Intervals:
    """Return both intervals of the values of equal, ranked blocks together (7.7.2, 7.7.3).

    An interval begins among the least of the values, and ends among as many of the greatest: these
    alone are sorted.
    """
    total, tail = sum(map(len, blocks)), _tail(len(blocks[0]), p)
    count = total - _count(total, p)
    # Each block has `tail` values up to `most`, so together there are at least `count`.
    most, least = max(block[tail - 1] for block in blocks), min(block[-tail] for block in blocks)
    low = np.sort(np.concatenate([block[block <= most] for block in blocks]))[:count]
    high = np.sort(np.concatenate([block[block >= least] for block in blocks]))[-count:]
    middle, narrowest = count // 2, int(np.argmin(high - low))
    return Intervals(*(Interval(float(low[k]), float(high[k])) for k in (middle, narrowest)))


def _count(n: int, p: float) -> int:
    """Return over how many steps of the ordered values an interval reaches."""
    return min(round(p * n), n - 1)


def _tail(n: int, p: float) -> int:
    """Return how many values of a block may lie before the begin of an interval, one to spare.

    For several blocks together their number is rounded once, not for each.
    """
    return min(n - floor(p * n) + 1, n)


def numerical_tolerance(u: float, digits: int) -> float:
    """Return half of the last of the digits that matter in a standard uncertainty (7.9.2)."""
    if u <= 0:
        return 0.0
    # Of the rounded value: with two digits 0.0996 is 0.10, which has another exponent.
    exponent = floor(log10(float(f"{u:.{digits - 1}e}"))) - (digits - 1)
    return 0.5 * 10.0**exponent
