"""How long samples keep one value: what a channel that hangs for a while looks like."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.blocks import blocks

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rigrunner.api.data import Samples


def longest_held(values: Samples, parts: int) -> NDArray[np.intp]:
    """Return the longest run of equal samples that begins in each part, shape (parts,).

    Of values (n,) cut into that many equal parts, 1 to n. A run that goes on into the next part
    counts whole where it begins.
    """
    size = len(values) / parts
    longest = np.ones(parts, np.intp)
    begins, lengths = _runs(values)
    part = np.minimum(begins / size, parts - 1).astype(np.intp)
    np.maximum.at(longest, part, lengths)
    return longest


def _runs(values: Samples) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return where samples equal to their predecessor begin to follow each other, and how many."""
    same = [np.empty(0, np.intp)]
    last = np.empty(0)
    for at, part in blocks(values):
        joined = np.concatenate([last, part])
        same.append(at - len(last) + np.flatnonzero(joined[1:] == joined[:-1]))
        last = part[-1:]
    repeats = np.concatenate(same)
    if not len(repeats):
        return repeats, repeats
    first = np.flatnonzero(np.diff(repeats, prepend=-2) > 1)
    return repeats[first], np.diff(first, append=len(repeats)) + 1
