"""Removal of single-sample spikes before anything else looks at the samples."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import median_filter

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rigrunner.api.data import Array

    IntArray = NDArray[np.intp]

MAD_TO_SIGMA = 1.482602218505602
"""1 / Phi^-1(3/4): the median absolute deviation of a normal distribution, as its sigma."""

DEFAULT_THRESHOLD = 6.0


def hampel(values: Array, window: int, threshold: float = DEFAULT_THRESHOLD) -> tuple[Array, int]:
    """Return values of shape (n,) with spikes replaced by the local median, and their number.

    A sample is a spike if it is further than `threshold` robust sigmas from the median of the
    `window` samples around it (Hampel identifier: Pearson, IEEE Trans. Control Syst. Technol.
    10(1), 2002). Sigma is the median absolute deviation in that window, which is large on steep
    slopes; but never less than what is usual in the whole record, so that a quiet stretch does not
    make spikes of good samples. An even window is widened by one. Raises ValueError for a window
    below 3.
    """
    if window < 3:  # noqa: PLR2004  (two neighbours are the least that can outvote a spike)
        raise ValueError(f"a window of {window} samples cannot tell a spike; 3 is the least")
    half = window // 2
    centre = median_filter(values, 2 * half + 1, mode="nearest")
    deviation = np.abs(values - centre)
    usual = MAD_TO_SIGMA * np.median(deviation)
    # Few samples pass this, and only these need their window's own deviation, which is costly.
    suspects = np.flatnonzero(deviation > threshold * usual)
    local = MAD_TO_SIGMA * _local_mad(values, suspects, half)
    spikes = suspects[deviation[suspects] > threshold * local]
    cleaned = values.copy()
    cleaned[spikes] = centre[spikes]
    return cleaned, len(spikes)


def _local_mad(values: Array, index: IntArray, half: int) -> Array:
    """Return the median absolute deviation in the windows around some samples."""
    padded = np.pad(values, half, mode="edge")
    windows = sliding_window_view(padded, 2 * half + 1)[index]
    centre = np.median(windows, axis=1, keepdims=True)
    return np.asarray(np.median(np.abs(windows - centre), axis=1))
