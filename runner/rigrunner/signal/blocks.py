"""Samples piece by piece: what is too long for memory is read in blocks, as often as is needed.

A recording that is no longer than one block is taken whole. Longer ones give the same to rounding,
for sums are then sums of sums.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rigrunner.api.data import Array, Samples

BLOCK = 1 << 21
"""Samples that are taken whole: 16 MB, and a few times that while they are looked at."""
STEP = 1 << 19
"""Samples of longer ones that are read from a file together: 4 MB stay in the processor's caches
from where they are unpacked to where they are looked at."""


def step_of(values: Samples) -> int:
    """Return how many samples are taken at once."""
    return BLOCK if isinstance(values, np.ndarray) or len(values) <= BLOCK else STEP


def steps(values: Samples) -> Iterator[tuple[int, int]]:
    """Yield where each block begins and ends."""
    step = step_of(values)
    for at in range(0, len(values), step):
        yield at, min(at + step, len(values))


def blocks(values: Samples) -> Iterator[tuple[int, Array]]:
    """Yield where each block begins, and its samples."""
    for begin, end in steps(values):
        yield begin, values[begin:end]


def less(values: Samples, zero: float) -> Samples:
    """Return values less a zero reading."""
    return values - zero if isinstance(values, np.ndarray) else Less(values, zero)


@dataclass(frozen=True, eq=False)
class Less:
    """Samples less a zero reading, taken off as they are read."""

    values: Samples
    zero: float

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.values)

    def __getitem__(self, which: slice, /) -> Array:
        """Return those from one index to another."""
        return self.values[which] - self.zero

    def __array__(self, dtype: object = None, *, copy: bool | None = None) -> Array:
        """Return all."""
        return self[:]

    @property
    def limits(self) -> tuple[float, float]:
        """Return the least and the greatest: to take off a number keeps their order."""
        least, greatest = limits(self.values)
        return least - self.zero, greatest - self.zero


def limits(values: Samples) -> tuple[float, float]:
    """Return the least and the greatest of values of shape (n,); raise ValueError without any.

    Both are not a number where one of the values is none. Samples that have `limits` know them.
    """
    own_limits: tuple[float, float] | None = getattr(values, "limits", None)
    return own_limits or limits_of(part for _, part in blocks(values))


def limits_of(parts: Iterable[Array]) -> tuple[float, float]:
    """Return the same of values in parts."""
    extremes = np.array([(part.min(), part.max()) for part in parts]).reshape(-1, 2)
    return float(extremes[:, 0].min()), float(extremes[:, 1].max())


def groups(places: Array) -> list[slice]:
    """Return slices of neighbours out of rising sample indices (n,), each of a block at most.

    A single place is a group too, however far the next one is.
    """
    slices, first = [], 0
    while first < len(places):
        end = max(int(np.searchsorted(places, places[first] + BLOCK, "right")), first + 1)
        slices.append(slice(first, end))
        first = end
    return slices


def cycle_groups(starts: Array) -> list[slice]:
    """Return the same of cycles, which begin at all but the last of `starts` (cycles + 1,).

    A cycle lies whole in one group.
    """
    slices, first = [], 0
    while first < len(starts) - 1:
        end = int(np.searchsorted(starts, starts[first] + STEP, "right")) - 1
        end = max(end, first + 1)
        slices.append(slice(first, end))
        first = end
    return slices
