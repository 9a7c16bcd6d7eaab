"""Means over cycles that a few bad samples cannot move, and what they are worth."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.spikes import MAD_TO_SIGMA

if TYPE_CHECKING:
    from rigrunner.api.data import Array, Mask

DEFAULT_THRESHOLD = 5.0


def trusted(cycles: Array, kept: Mask, threshold: float = DEFAULT_THRESHOLD) -> Mask:
    """Return which samples of the cycles, shape (cycles, n), take part in the mean.

    Those of kept cycles that lie within `threshold` robust sigmas of the median over the kept
    cycles at their phase; sigma is the median absolute deviation there, or over the whole swing if
    that is larger (of few cycles it is itself uncertain).
    """
    deviation = np.abs(cycles - np.median(cycles[kept], axis=0))
    mad = np.median(deviation[kept], axis=0)
    sigma = MAD_TO_SIGMA * np.maximum(mad, np.sqrt(np.mean(mad**2)))
    mask: Mask = (deviation <= threshold * sigma) & kept[:, None]
    return mask


def robust_mean(
    cycles: Array, kept: Mask, threshold: float = DEFAULT_THRESHOLD
) -> tuple[Array, Array]:
    """Return the mean over the kept cycles and its standard error, both of shape (n,).

    `cycles` has shape (cycles, n), `kept` (cycles,); samples that are not `trusted` are left out.
    Raises ValueError for fewer than two kept cycles.
    """
    if kept.sum() < 2:  # noqa: PLR2004  (one cycle has no scatter)
        raise ValueError("a mean with its standard error needs two cycles")
    mask = trusted(cycles, kept, threshold)
    count = mask.sum(axis=0)
    mean = np.where(mask, cycles, 0.0).sum(axis=0) / count
    squares = np.where(mask, (cycles - mean) ** 2, 0.0).sum(axis=0)
    return mean, np.sqrt(squares / (np.maximum(count - 1, 1) * count))


def leave_one_out_means(cycles: Array, kept: Mask, threshold: float = DEFAULT_THRESHOLD) -> Array:
    """Return the robust mean without each of the kept cycles in turn, shape (kept, n)."""
    mask = trusted(cycles, kept, threshold)
    total = np.where(mask, cycles, 0.0).sum(axis=0)
    without = np.where(mask, total - cycles, total)[kept]
    count = (mask.sum(axis=0) - mask)[kept]
    means: Array = without / np.maximum(count, 1)
    return means
