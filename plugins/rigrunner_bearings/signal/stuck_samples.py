"""How long samples keep one value, as those of a channel that hangs for a while."""

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
    counts as a whole in the part in which it begins.
    """
    size = len(values) / parts
    longest = np.ones(parts, np.intp)
    for begins, lengths, _ in _runs(values):
        part = np.minimum(begins / size, parts - 1).astype(np.intp)
        np.maximum.at(longest, part, lengths)
    return longest


def longest_at(values: Samples, levels: Sequence[float]) -> int:
    """Return the longest run of samples at one of these levels; each level must occur."""
    runs = ((lengths, np.isin(level, levels)) for _, lengths, level in _runs(values))
    return max(int(lengths[at_levels].max(initial=1)) for lengths, at_levels in runs)


def _runs(values: Samples) -> Iterator[tuple[IntArray, IntArray, Array]]:
    """Yield the starts of runs of two or more equal samples, their lengths and values, by blocks.

    A run that continues in the next block is yielded again, with its length so far.
    """
    previous, began, length = np.empty(0), 0, 1
    for start, part in blocks(values):
        joined = np.concatenate([previous, part])
        equal = np.flatnonzero(joined[1:] == joined[:-1])
        first = np.flatnonzero(np.diff(equal, prepend=-2) > 1)
        begins = equal[first] + (start - len(previous))
        lengths = np.diff(first, append=len(equal)) + 1
        if len(previous) and len(equal) and equal[0] == 0:
            begins[0], lengths[0] = began, length + lengths[0] - 1
        yield begins, lengths, joined[equal[first]]
        continues = len(equal) and equal[-1] == len(joined) - 2
        began, length = (begins[-1], lengths[-1]) if continues else (start + len(part) - 1, 1)
        previous = part[-1:]
