"""Samples between the samples: local polynomials, for streams that must not wait for their end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rigrunner.api.data import Array

NODES = np.arange(-2, 4)
"""The six samples around a place between samples 0 and 1."""
BEFORE, BEHIND = 2, 3
"""How many samples are needed before a place, beside the one at or below it, and behind it."""


def between(samples: Array, positions: Array) -> Array:
    """Return samples (n,) at fractional positions (m,) by Lagrange's polynomials of degree 5.

    Each position p needs BEFORE <= p < n - BEHIND; raises ValueError for any other. Up to a tenth
    of the sampling rate the error is below 0.1 % of the amplitude.
    """
    first = np.floor(positions).astype(np.intp)
    if len(first) and (first.min() < BEFORE or first.max() >= len(samples) - BEHIND):
        raise ValueError("a position is too near to the ends of the samples, or beyond them")
    part = positions - first
    total = np.zeros(len(positions))
    for node in NODES:
        others = NODES[node != NODES]
        weight = np.prod((part[:, None] - others) / (node - others), axis=1)
        total += weight * samples[first + node]
    return total
