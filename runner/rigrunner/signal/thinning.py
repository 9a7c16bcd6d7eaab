"""Which of many values a figure shows, so that its size does not grow with the run."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rigrunner.api.data import Array

Places = NDArray[np.intp]


def places_of_extremes(*series: Array, most: int) -> Places:
    """Return the places, in order, of at most `most` values that show what all of them show.

    `series` are of one length, shape (N,) each, and `most` is at least two for each. All places
    where there are no more than `most`; else those of the least and the greatest value of each
    series in each of equal stretches, by which no extreme is lost. A value that is not a number
    is no extreme.
    """
    count = len(series[0])
    if count <= most:
        return np.arange(count)
    parts = most // (2 * len(series))
    edges = count * np.arange(parts + 1) // parts
    places = {
        start + place
        for values in series
        for start, end in pairwise(edges)
        for place in _least_and_greatest(values[start:end])
    }
    return np.array(sorted(places), dtype=np.intp)


def _least_and_greatest(values: Array) -> tuple[int, int]:
    unknown = np.isnan(values)
    least = np.argmin(np.where(unknown, np.inf, values))
    return int(least), int(np.argmax(np.where(unknown, -np.inf, values)))
