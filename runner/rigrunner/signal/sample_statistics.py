"""Statistics of a stream of samples, taken block by block: memory does not grow with its length."""

from __future__ import annotations

from math import fsum, sqrt
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rigrunner.api.data import Array


class SampleStatistics:
    """Mean, extremes, peak-to-peak and root mean square of all samples that were taken.

    In the unit of the samples. How they were cut into blocks changes mean and root mean square by
    no more than rounding.
    """

    def __init__(self) -> None:
        self._count = 0
        self._sums: list[float] = []
        self._squares: list[float] = []
        self._least = self._greatest = 0.0

    def take(self, values: Array) -> None:
        """Take further samples, shape (n,), finite."""
        if not len(values):
            return
        least, greatest = float(values.min()), float(values.max())
        self._least = min(self._least, least) if self._count else least
        self._greatest = max(self._greatest, greatest) if self._count else greatest
        self._count += len(values)
        _add(self._sums, float(values.sum()))
        _add(self._squares, float(values @ values))

    def by_name(self) -> dict[str, float]:
        """Return every statistic by its name; raise ValueError where no sample was taken."""
        if not self._count:
            raise ValueError("there is no sample to take statistics of")
        return {
            "mean": fsum(self._sums) / self._count,
            "minimum": self._least,
            "maximum": self._greatest,
            "peak_to_peak": self._greatest - self._least,
            "rms": sqrt(fsum(self._squares) / self._count),
        }


def _add(parts: list[float], value: float) -> None:
    """Add to a sum that is kept as its value and what rounding took from it (Knuth's TwoSum)."""
    total = parts[0] if parts else 0.0
    error = parts[1] if parts else 0.0
    added = total + value
    taken = added - total
    error += (total - (added - taken)) + (value - taken)
    parts[:] = [added, error]
