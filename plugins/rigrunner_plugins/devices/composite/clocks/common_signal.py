"""By how much one recording of a signal is late against another one of the same signal."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.interpolation import between

if TYPE_CHECKING:
    from rigrunner.api import Array

ALIKE = 0.95
"""The least correlation by which two recordings are taken to be of one signal."""
UNIQUE = 0.98
"""Of the greatest correlation: where another lag comes as near, the signal repeats itself."""
SMOOTHED = 31
"""Over how many samples of the window (a Hann window)."""
_ROUNDS = 20
"""Gauss-Newton steps at most: each goes a sample at most, and the start is right to a sample."""
_STEP = 0.5
"""In samples, on both sides: over which a slope is taken."""


@dataclass(frozen=True)
class Lag:
    """Where in the other recording the first sample of the window is, in samples of that one."""

    samples: float
    u_samples: float


def coarse_lag(window: Array, other: Array, stride: float) -> float | None:
    """Return where in `other` (m,) the window (n,) begins, to a sample; None where unclear.

    `stride` is how many samples of the other make one of the window. The whole of `other` is
    searched; it is unclear where the signal stands still, differs, or repeats itself.
    """
    grid = np.arange(len(window)) * stride
    places = np.arange(0, len(other) - int(np.ceil(grid[-1])) - 1)
    if len(places) < 3 or np.ptp(window) == 0:  # noqa: PLR2004  (a maximum has two neighbours)
        return None
    offsets = np.round(grid).astype(np.intp)
    scores = np.array([_correlation(window, other[place + offsets]) for place in places])
    best = int(scores.argmax())
    maxima = 1 + np.flatnonzero((scores[1:-1] > scores[:-2]) & (scores[1:-1] >= scores[2:]))
    repeats = any(scores[index] > UNIQUE * scores[best] for index in maxima if index != best)
    return None if scores[best] < ALIKE or repeats else float(places[best])


def fine_lag(window: Array, other: Array, stride: float, start: float) -> Lag | None:
    """Return the lag by least squares, begun near `start`; None where it is not found there.

    window = gain other(lag + stride k) + constant, in k: the lag has a standard uncertainty by what
    remains (Gauss-Newton; GUM 4.3.1, type A). Both are smoothed alike before: the slope of noise
    would pass for a slope of the signal.
    """
    weights, other_weights = _hann(SMOOTHED), _hann(SMOOTHED * stride)
    shift = stride * (len(weights) // 2) - len(other_weights) // 2
    lag = _least_squares(
        np.convolve(window, weights, "valid"),
        np.convolve(other, other_weights, "valid"),
        stride,
        start + shift,
    )
    if lag is None:
        return None
    # White noise is correlated from sample to sample now: it shows less than it seems to.
    return Lag(lag.samples - shift, lag.u_samples / sqrt(float(weights @ weights)))


def _hann(samples: float) -> Array:
    """Return weights of a sum of 1 over about so many samples, an odd number."""
    count = 2 * round((samples - 1) / 2) + 1
    weights = np.hanning(count + 2)[1:-1]
    return np.asarray(weights / weights.sum())


def _least_squares(window: Array, other: Array, stride: float, start: float) -> Lag | None:
    count = len(window)
    lag, grid = start, np.arange(count, dtype=np.float64) * stride
    for _ in range(_ROUNDS):
        if lag < 3 or lag + grid[-1] > len(other) - 5:  # noqa: PLR2004  (what interpolation needs)
            return None
        places = np.asarray(lag + grid)
        here = between(other, places)
        slope = between(other, places + _STEP) - between(other, places - _STEP)
        # Linear in a small step: gain other(lag + step) = gain here + gain step slope.
        design = np.stack([here, np.ones(count), slope], axis=1)
        solution, *_ = np.linalg.lstsq(design, window, rcond=None)
        gain, _, shift = solution
        if gain == 0:
            return None
        # A slope holds for about a sample; a longer step could leave the maximum.
        step = float(np.clip(shift / gain, -1.0, 1.0))
        lag += step
        if abs(step) < 1e-4:  # noqa: PLR2004  (of a sample)
            break
    residual = window - design @ solution
    # The part of the slope that gain and offset cannot explain: it alone determines the lag.
    explained, *_ = np.linalg.lstsq(design[:, :2], slope, rcond=None)
    remainder = slope - design[:, :2] @ explained
    spread = float(remainder @ remainder)
    if _correlation(window, here) < ALIKE or spread == 0:
        return None
    scatter = sqrt(float(residual @ residual) / max(count - 3, 1))
    return Lag(lag, scatter / (abs(gain) * sqrt(spread)))


def _correlation(one: Array, two: Array) -> float:
    a, b = one - one.mean(), two - two.mean()
    size = sqrt(float(a @ a) * float(b @ b))
    return float(a @ b) / size if size > 0 else 0.0
