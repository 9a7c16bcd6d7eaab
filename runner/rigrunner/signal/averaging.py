"""Means over cycles that a few bad samples cannot move, and what they are worth."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.spikes import MAD_TO_SIGMA

if TYPE_CHECKING:
    from rigrunner.api.data import Array, Mask

DEFAULT_THRESHOLD = 5.0
"""In robust sigmas: of normal samples one in 1.7 million lies further out."""


def trusted(cycles: Array, kept: Mask, threshold: float = DEFAULT_THRESHOLD) -> Mask:
    """Return which samples of the cycles, shape (cycles, n), take part in the mean.

    Those of kept cycles that lie within `threshold` robust sigmas of the median over the kept
    cycles at their phase; sigma is the median absolute deviation there, or over the whole cycle if
    that is larger (of few cycles it is itself uncertain).
    """
    deviation = np.abs(cycles - median_over_cycles(cycles[kept]))
    mad = median_over_cycles(deviation[kept])
    sigma = MAD_TO_SIGMA * np.maximum(mad, np.sqrt(np.mean(mad**2)))
    mask: Mask = (deviation <= threshold * sigma) & kept[:, None]
    return mask


def median_over_cycles(cycles: Array) -> Array:
    """Return the median at each phase of cycles of shape (cycles, n), shape (n,).

    The same bits as np.median(cycles, axis=0): sorting many short rows takes a tenth to half of the
    time of partitioning them.
    """
    count = len(cycles)
    ranked = np.sort(np.ascontiguousarray(cycles.T), axis=-1)
    median: Array = ranked[:, (count - 1) // 2 : count // 2 + 1].mean(axis=-1)
    median[np.isnan(ranked[:, -1:]).any(axis=-1)] = np.nan  # what is not a number is sorted last
    return median


def robust_mean(
    cycles: Array, kept: Mask, threshold: float = DEFAULT_THRESHOLD
) -> tuple[Array, Array]:
    """Return the mean over the kept cycles and its standard error, both of shape (n,).

    `cycles` has shape (cycles, n), `kept` (cycles,); samples that are not `trusted` are left out.
    Raises ValueError for fewer than two kept cycles.
    """
    _need_two(kept)
    mask = trusted(cycles, kept, threshold)
    count = mask.sum(axis=0)
    # Never 0: half of the kept cycles lie within the median absolute deviation, so within sigma.
    mean = np.where(mask, cycles, 0.0).sum(axis=0) / count
    squares = np.where(mask, (cycles - mean) ** 2, 0.0).sum(axis=0)
    return mean, np.sqrt(squares / (np.maximum(count - 1, 1) * count))


def mean_and_without_each(
    cycles: Array, kept: Mask, threshold: float = DEFAULT_THRESHOLD
) -> tuple[Array, Array]:
    """Return the mean of `robust_mean` and the mean without each of the kept cycles in turn.

    Shapes (n,) and (kept, n). Raises ValueError for fewer than two kept cycles.
    """
    _need_two(kept)
    mask = trusted(cycles, kept, threshold)
    total, count = np.where(mask, cycles, 0.0).sum(axis=0), mask.sum(axis=0)
    without = np.where(mask, total - cycles, total)[kept]
    means: Array = without / np.maximum((count - mask)[kept], 1)
    return total / count, means


def _need_two(kept: Mask) -> None:
    if kept.sum() < 2:  # noqa: PLR2004  (one cycle has no scatter)
        raise ValueError("a mean with its standard error needs two cycles")
