"""The least and greatest sample of each cycle, at about the speed at which memory is read."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.blocks import step_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rigrunner.api.data import Array, Samples

    IntArray = NDArray[np.intp]

CACHED = 1 << 16
"""Samples that stay in a core's own cache (512 kB): the second look at them costs a third."""


def extremes(values: Samples, edges: IntArray) -> tuple[Array, Array]:
    """Return the least and the greatest of values[edges[k]:edges[k + 1]], each of shape (m,).

    `values` has shape (n,); `edges` has shape (m + 1,), rises strictly and lies within 0 ... n.
    Equal, bit by bit, to min() and max() of each part.
    """
    if len(edges) < 2:  # noqa: PLR2004  (a part has two ends)
        return np.empty(0), np.empty(0)
    first, count, step = int(edges[0]), int(edges[-1] - edges[0]), step_of(values)
    # Parts are cut where the cached stretches end, and put together again at the end.
    cuts = np.arange(0, count, CACHED)
    starts = np.sort(np.concatenate([edges[:-1] - first, cuts]), kind="stable")
    least, greatest = np.empty(len(starts)), np.empty(len(starts))
    within = starts % CACHED
    pieces = np.append(np.searchsorted(starts, cuts), len(starts))
    for k, at in enumerate(cuts.tolist()):
        # step is a multiple of CACHED, so a cached stretch lies within one block.
        if at % step == 0:
            block = values[first + at : first + min(at + step, count)]
        cached, inside = block[at % step :][:CACHED], slice(pieces[k], pieces[k + 1])
        np.minimum.reduceat(cached, within[inside], out=least[inside])
        np.maximum.reduceat(cached, within[inside], out=greatest[inside])
    part_starts = np.searchsorted(starts, edges[:-1] - first)
    return np.minimum.reduceat(least, part_starts), np.maximum.reduceat(greatest, part_starts)
