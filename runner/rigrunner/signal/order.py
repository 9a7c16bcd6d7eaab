"""Order statistics of more samples than fit into memory, exact, in a few passes over them.

The first bits of a float64 tell about where it stands among others. Counting by them narrows each
wanted rank to a few values, or to some that are all the same.
"""

from __future__ import annotations

from math import floor
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
SHIFTS = (44, 24, 4, 0)
"""Bits that a pass leaves open. The first 20 tell apart what differs by a 256th."""
SIGN = np.uint64(1 << 63)


def percentiles(values: Samples, percent: Sequence[float]) -> list[float]:
    """Return what `np.percentile` does, of values of shape (n,), bit by bit."""
    if len(values) <= BLOCK:
        return [float(each) for each in np.percentile(values[:], percent)]
    places = [(len(values) - 1) * (each / 100) for each in percent]
    last = len(values) - 1
    ranks = [rank for at in places for rank in (floor(at), min(floor(at) + 1, last))]
    found = iter(ranked(lambda: (part for _, part in blocks(values)), ranks))
    pairs = [(next(found), next(found), place - floor(place)) for place in places]
    return [float(np.quantile([low, high], share)) for low, high, share in pairs]


def median(parts: Parts, count: int) -> float:
    """Return what `np.median` does, of `count` values in parts, bit by bit."""
    if count <= BLOCK:
        return float(np.median(np.concatenate(list(parts()))))
    return float(np.mean(ranked(parts, sorted({(count - 1) // 2, count // 2}))))


def ranked(parts: Parts, ranks: Sequence[int]) -> list[float]:
    """Return the values that would stand at these places, if all were sorted."""
    known, below = [0] * len(ranks), [0] * len(ranks)
    opened = 64
    for shift in SHIFTS:
        tables = _counted(parts, set(known), opened, shift)
        held = {}
        for k, rank in enumerate(ranks):
            total = below[k] + np.cumsum(tables[known[k]])
            place = int(np.searchsorted(total, rank, "right"))
            count = int(tables[known[k]][place])
            below[k] = int(total[place]) - count
            known[k] = (known[k] << (opened - shift)) + place
            held[known[k]] = count
        opened = shift
        if sum(held.values()) <= KEPT:
            break
    if not opened:
        return [float(each) for each in _values(known)]
    ordered = _gathered(parts, set(known), opened)
    return [float(ordered[k][r - b]) for k, r, b in zip(known, ranks, below, strict=True)]


def _counted(
    parts: Parts, known: set[int], opened: int, shift: int
) -> dict[int, NDArray[np.int64]]:
    """Return for each of the known first bits how many values go on with which next ones."""
    size = 1 << (opened - shift)
    tables = {first: np.zeros(size, np.int64) for first in known}
    for part in parts():
        keys = _keys(part)
        for first in known:
            mine = keys if opened == 64 else keys[keys >> opened == first]  # noqa: PLR2004  (all)
            places = (mine >> shift) & (size - 1)
            tables[first] += np.bincount(places.astype(np.intp), minlength=size)
    return tables


def _gathered(parts: Parts, known: set[int], opened: int) -> dict[int, Array]:
    found: dict[int, list[Array]] = {first: [] for first in known}
    for part in parts():
        keys = _keys(part)
        for first, some in found.items():
            some.append(part[keys >> opened == first])
    return {first: np.sort(np.concatenate(some)) for first, some in found.items()}


def _keys(values: Array) -> Keys:
    """Return whole numbers that have the order of the values (IEEE 754)."""
    bits = np.ascontiguousarray(values).view(np.uint64)
    return np.where(bits >> 63, ~bits, bits | SIGN)


def _values(keys: Sequence[int]) -> Array:
    bits = np.array(keys, np.uint64)
    return np.where(bits >> 63, bits ^ SIGN, ~bits).view(np.float64)
