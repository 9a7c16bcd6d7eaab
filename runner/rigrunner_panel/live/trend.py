"""A channel over time for the screen: the lowest and highest sample of each column in a window."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]

COLUMNS = 1200
STEP_S = 0.05


class Trend:
    """A ring buffer of columns of bounded size; column i covers [i, i + 1) * STEP_S seconds."""

    def __init__(self) -> None:
        self._low = np.full(COLUMNS, np.nan, np.float32)
        self._high = np.full(COLUMNS, np.nan, np.float32)
        self._last = -1

    @property
    def last(self) -> int:
        """The latest column; -1 before the first sample."""
        return self._last

    @property
    def first(self) -> int:
        """The earliest column that is still stored."""
        return max(0, self._last - COLUMNS + 1)

    def take(self, start_s: float, rate_hz: float, values: Floats) -> int:
        """Add samples of shape (n,), the first at `start_s`; return the first changed column."""
        columns = ((start_s + np.arange(len(values)) / rate_hz) / STEP_S).astype(np.int64)
        keep = columns > self._last - COLUMNS
        columns, values = columns[keep], values[keep]
        if not len(values):
            return self._last + 1
        self._go_to(int(columns[-1]))
        starts = np.flatnonzero(np.diff(columns, prepend=columns[0] - 1))
        places = columns[starts] % COLUMNS
        # Columns without a sample so far are NaN, which fmin and fmax pass over.
        self._low[places] = np.fmin(self._low[places], np.minimum.reduceat(values, starts))
        self._high[places] = np.fmax(self._high[places], np.maximum.reduceat(values, starts))
        return int(columns[0])

    def since(self, first: int) -> tuple[int, Floats, Floats]:
        """Return the stored columns from `first` on: first, low, high."""
        first = max(first, self.first)
        places = np.arange(first, self._last + 1) % COLUMNS
        return first, self._low[places], self._high[places]

    def _go_to(self, column: int) -> None:
        """Advance to a column; skipped columns are empty."""
        if column <= self._last:
            return
        fresh = np.arange(max(self._last + 1, column - COLUMNS + 1), column + 1) % COLUMNS
        self._low[fresh] = self._high[fresh] = np.nan
        self._last = column
