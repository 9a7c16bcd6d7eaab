"""How long samples keep one value: what a channel that hangs for a while looks like."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.blocks import blocks

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from rigrunner.api import Array
    from rigrunner.api.data import Samples

    IntArray = NDArray[np.intp]


def longest_stuck(values: Samples, parts: int) -> IntArray:
    """Return the longest run of equal samples that begins in each part, shape (parts,).

    Of values (n,) cut into that many equal parts, 1 to n. A run that continues in the next part
    counts whole where it begins.
    """
    size = len(values) / parts
    longest = np.ones(parts, np.intp)
    for begins, lengths, _ in _runs(values):
        part = np.minimum(begins / size, parts - 1).astype(np.intp)
        np.maximum.at(longest, part, lengths)
    return longest


def longest_at(values: Samples, levels: Sequence[float]) -> int:
    """Return how many samples in a row have one of these values, at most; each has to occur."""
    runs = ((lengths, np.isin(held, levels)) for _, lengths, held in _runs(values))
    return max(int(lengths[mine].max(initial=1)) for lengths, mine in runs)


def _runs(values: Samples) -> Iterator[tuple[IntArray, IntArray, Array]]:
    """Yield where two samples or more are equal, how many they are, and their value, by blocks.

    A run that continues in the next block is there again, with its length up to there.
    """
    last, began, length = np.empty(0), 0, 1
    for at, part in blocks(values):
        joined = np.concatenate([last, part])
        same = np.flatnonzero(joined[1:] == joined[:-1])
        first = np.flatnonzero(np.diff(same, prepend=-2) > 1)
        begins = same[first] + (at - len(last))
        lengths = np.diff(first, append=len(same)) + 1
        if len(last) and len(same) and same[0] == 0:
            begins[0], lengths[0] = began, length + lengths[0] - 1
        yield begins, lengths, joined[same[first]]
        continues = len(same) and same[-1] == len(joined) - 2
        began, length = (begins[-1], lengths[-1]) if continues else (at + len(part) - 1, 1)
        last = part[-1:]
