"""Samples of a device or a file, as numbers of which nothing is left out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rigrunner.api.data import Array

_REAL_NUMBERS = "fiub"
"""The kinds of NumPy's types that become float64 as they are."""


def as_samples(values: object) -> Array:
    """Return real numbers as float64; raise TypeError saying what they are instead.

    NumPy would leave out an imaginary part, a mask or a unit of time with no more than a warning.
    """
    if type(values) is np.ndarray and values.dtype == np.float64:
        return values
    if isinstance(values, np.ma.MaskedArray):
        raise TypeError("masked")
    array = np.asarray(values)
    if array.dtype.kind not in _REAL_NUMBERS:
        raise TypeError(str(array.dtype))
    return array.astype(np.float64)
