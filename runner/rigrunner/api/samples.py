"""Samples of a device or a file, converted to numbers without loss."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rigrunner.api.data import Array

_REAL_NUMBERS = "fiub"
"""The kinds of NumPy types that convert to float64 directly."""


def as_samples(values: object) -> Array:
    """Return real numbers as float64; raise TypeError naming the type of anything else.

    NumPy would drop an imaginary part, a mask or a unit of time with a warning at most.
    """
    # Not isinstance: a masked array is an ndarray too.
    if type(values) is np.ndarray and values.dtype == np.float64:
        return values
    if isinstance(values, np.ma.MaskedArray):
        raise TypeError("masked")
    array = np.asarray(values)
    if array.dtype.kind not in _REAL_NUMBERS:
        raise TypeError(str(array.dtype))
    return array.astype(np.float64)
