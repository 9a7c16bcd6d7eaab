"""Every cycle on the crank phase: its torque, and the mean of its angle.

Of very many cycles neighbours are averaged, so that memory does not grow with the recording. A row
of several scatters less, as a mean does, and the uncertainty of the mean over all rows is the same,
for every row is of equally many cycles; where that does not come out even, a few have one less.

A gross error in one cycle of a row of m is m times smaller there, against a scatter that is sqrt(m)
smaller. Where it is still seen, its neighbours go with it; where not, it is one of thousands.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.signal.cycles import resample, resampled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rigrunner.api import Array, Mask
    from rigrunner.api.data import Samples

PHASES = 1024
MOST_ROWS = 1024
"""8 MB a recording, and no method holds more than a few times that."""


def rows_of(cycles: int) -> int:
    """Return in how many rows that many cycles are put, MOST_ROWS at most.

    Rows of one cycle beside rows of two would count twice as much in a mean over rows: at 1500
    cycles its uncertainty would be 6 % larger than that of the mean over cycles.
    """
    together = -(-cycles // MOST_ROWS)
    return -(-cycles // together)


def row_of(cycles: int) -> NDArray[np.intp]:
    """Return the row in which each cycle is, shape (cycles,)."""
    return np.arange(cycles) * rows_of(cycles) // cycles


def waveforms(values: Samples, starts: Array) -> Array:
    """Return the cycles between `starts` on PHASES phases, shape (rows, PHASES)."""
    cycles = len(starts) - 1
    if cycles <= MOST_ROWS:
        return resample(values, starts, PHASES)
    row = row_of(cycles)
    total = np.zeros((rows_of(cycles), PHASES))
    for part, block in resampled(values, starts, PHASES):
        rows, first = np.unique(row[part], return_index=True)
        total[rows] += np.add.reduceat(block, first, axis=0)
    return np.asarray(total / np.bincount(row)[:, None])


def mean_of(values: Samples, starts: Array, offset: float, kept: Mask) -> Array:
    """Return the mean of values less an offset over the kept cycles, shape (PHASES,)."""
    total = np.zeros(PHASES)
    for part, rows in resampled(values, starts, PHASES):
        kept_rows = (rows - offset)[kept[part]]
        if len(kept_rows) == kept.sum():
            return np.asarray(kept_rows.mean(axis=0))
        total += kept_rows.sum(axis=0)
    return np.asarray(total / kept.sum())
