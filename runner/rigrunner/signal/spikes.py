"""Removal of single-sample spikes before anything else looks at the samples."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import median_filter

if TYPE_CHECKING:
    from rigrunner.api.data import Array

MAD_TO_SIGMA = 1.482602218505602
"""1 / Phi^-1(3/4): the median absolute deviation of a normal distribution, as its sigma."""

DEFAULT_THRESHOLD = 6.0


def hampel(values: Array, window: int, threshold: float = DEFAULT_THRESHOLD) -> tuple[Array, int]:
    """Return values of shape (n,) with spikes replaced by the local median, and their number.

    A sample is a spike if it is further than `threshold` robust sigmas from the median of the
    `window` samples around it (Hampel identifier: Pearson, IEEE Trans. Control Syst. Technol.
    10(1), 2002). Sigma is the local median absolute deviation, but never less than that of the
    whole record: so neither steep slopes nor a quiet stretch make spikes of good samples. An even
    window is widened by one. Raises ValueError for a window below 3.
    """
    if window < 3:  # noqa: PLR2004  (two neighbours are the least that can outvote a spike)
        raise ValueError(f"a window of {window} samples cannot tell a spike; 3 is the least")
    size = window + 1 - window % 2
    centre = median_filter(values, size, mode="nearest")
    deviation = np.abs(values - centre)
    local = median_filter(deviation, size, mode="nearest")
    sigma = MAD_TO_SIGMA * np.maximum(local, np.median(deviation))
    spikes = deviation > threshold * sigma
    return np.where(spikes, centre, values), int(spikes.sum())
