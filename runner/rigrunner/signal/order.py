"""Order statistics of more samples than fit into memory, exact, in few passes over them.

The first block shows about where a rank is, and one pass then keeps the values there. Where
the rest is not like the first block, the first bits of a float64 give its place among the others:
counting by them narrows each rank to a few values, or to equal ones.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import ceil, floor
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.blocks import BLOCK, blocks

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import NDArray

    from rigrunner.api.data import Array, Samples

    Keys = NDArray[np.uint64]
    Parts = Callable[[], Iterable[Array]]

KEPT = 1 << 21
"""Samples that are kept to be sorted, once no more than these come into question."""
SLACK = 1.5
"""Times KEPT that a bracket keeps different values before it gives up; it is laid to hold KEPT."""
WIDE = 0.03
"""Of all values, on either side: the most that a bracket is laid to hold of few."""
SHIFTS = (44, 24, 4, 0)
"""Bits that a pass leaves open. The first 20 distinguish what differs by a 256th."""
SIGN = np.uint64(1 << 63)


@dataclass(eq=False)
class Bracket:
    """Takes values in parts: keeps those from `low` to `high`, and counts what is below."""

    low: float
    high: float
    below: int = 0
    _kept: list[tuple[Array, NDArray[np.intp]]] = field(default_factory=list)
    """Different values, rising, and how often each came."""
    _size: int = 0

    @classmethod
    def about(cls, share: float, first: Array, count: int) -> Bracket:
        """Return one about the value below which that share of `count` lies, by the first ones."""
        half = min(KEPT / count / 2, WIDE)
        places = [np.clip(share + way * half, 0, 1) * (len(first) - 1) for way in (-1, 1)]
        ends = [floor(places[0]), ceil(places[1])]
        low, high = np.partition(first, ends)[ends]
        return cls(float(low), float(high))

    def take(self, part: Array) -> None:
        """Take further values."""
        self.below += int(np.count_nonzero(part < self.low))
        if self._size <= SLACK * KEPT:
            inside = part[(part >= self.low) & (part <= self.high)]
            self._kept.append(np.unique(inside, return_counts=True))
            self._size += len(self._kept[-1][0])

    def ranked(self, ranks: Sequence[int]) -> list[float] | None:
        """Return the values that would stand at these places; None where they are not all kept."""
        values, counts = (np.concatenate(arrays) for arrays in zip(*self._kept, strict=True))
        order = np.argsort(values, kind="stable")
        ends = self.below + np.cumsum(counts[order])
        inside = len(ends) and self.below <= min(ranks) and max(ranks) < ends[-1]
        if not inside or self._size > SLACK * KEPT:
            return None
        return [float(value) for value in values[order[np.searchsorted(ends, ranks, "right")]]]


def percentiles(values: Samples, percent: Sequence[float]) -> list[float]:
    """Return what `np.percentile` does, of values of shape (n,), bit by bit."""
    if len(values) <= BLOCK:
        return [float(value) for value in np.percentile(values[:], percent)]
    places = [(len(values) - 1) * (percentage / 100) for percentage in percent]
    last = len(values) - 1
    ranks = [[floor(at), min(floor(at) + 1, last)] for at in places]
    first = values[:BLOCK]
    brackets = [Bracket.about(percentage / 100, first, len(values)) for percentage in percent]
    for _, part in blocks(values):
        for bracket in brackets:
            bracket.take(part)
    pairs = [
        bracket.ranked(pair) or ranked(lambda: (part for _, part in blocks(values)), pair)
        for bracket, pair in zip(brackets, ranks, strict=True)
    ]
    # Between the two neighbours of a place numpy interpolates as it does among all values.
    shares = (place - floor(place) for place in places)
    return [float(np.quantile(pair, share)) for pair, share in zip(pairs, shares, strict=True)]


def middle(count: int) -> list[int]:
    """Return the places of those of `count` ordered values whose mean is the median."""
    return sorted({(count - 1) // 2, count // 2})


def median(parts: Parts, count: int) -> float:
    """Return what `np.median` does, of `count` values in parts, bit by bit."""
    if count <= BLOCK:
        return float(np.median(np.concatenate(list(parts()))))
    return float(np.mean(ranked(parts, middle(count))))


def ranked(parts: Parts, ranks: Sequence[int]) -> list[float]:
    """Return the values that would stand at these places, if all were sorted."""
    # Of each rank: the first bits of its value as far as they are known, and how many values are
    # less by these bits.
    prefixes, below = [0] * len(ranks), [0] * len(ranks)
    opened = 64
    for shift in SHIFTS:
        tables = _count_next_bits(parts, set(prefixes), opened, shift)
        counts = {}
        for k, rank in enumerate(ranks):
            total = below[k] + np.cumsum(tables[prefixes[k]])
            place = int(np.searchsorted(total, rank, "right"))
            count = int(tables[prefixes[k]][place])
            below[k] = int(total[place]) - count
            prefixes[k] = (prefixes[k] << (opened - shift)) + place
            counts[prefixes[k]] = count
        opened = shift
        if sum(counts.values()) <= KEPT:
            break
    if not opened:
        # All bits are known: the values themselves, by the inverse of `_keys`.
        bits = np.array(prefixes, np.uint64)
        values = np.where(bits >> 63, bits ^ SIGN, ~bits).view(np.float64)
        return [float(value) for value in values]
    groups: dict[int, list[Array]] = {prefix: [] for prefix in prefixes}
    for part in parts():
        keys = _keys(part)
        for prefix, group in groups.items():
            group.append(part[keys >> opened == prefix])
    ordered = {prefix: np.sort(np.concatenate(group)) for prefix, group in groups.items()}
    return [float(ordered[p][r - b]) for p, r, b in zip(prefixes, ranks, below, strict=True)]


def _count_next_bits(
    parts: Parts, prefixes: set[int], opened: int, shift: int
) -> dict[int, NDArray[np.int64]]:
    """Return for each prefix how many values go on with which next bits."""
    size = 1 << (opened - shift)
    tables = {prefix: np.zeros(size, np.int64) for prefix in prefixes}
    for part in parts():
        keys = _keys(part)
        for prefix in prefixes:
            matching = keys if opened == 64 else keys[keys >> opened == prefix]  # noqa: PLR2004  (all)
            places = (matching >> shift) & (size - 1)
            tables[prefix] += np.bincount(places.astype(np.intp), minlength=size)
    return tables


def _keys(values: Array) -> Keys:
    """Return whole numbers that have the order of the values (IEEE 754)."""
    bits = np.ascontiguousarray(values).view(np.uint64)
    # The bits of a negative number rise as it falls, so they are turned; others come above these.
    return np.where(bits >> 63, ~bits, bits | SIGN)
