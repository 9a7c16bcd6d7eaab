"""By how much noise raises a maximum: estimated from the cycles' own scatter, to be taken off.

The greatest of several values that each err is on average too great. The cycles' deviations from
their mean say how the mean curve errs; curves with such errors once more added show how much their
maximum is raised (parametric bootstrap of the bias: Efron and Tibshirani, An Introduction to the
Bootstrap, 10). Each error is taken with both signs, so that where the maximum is smooth, and has
no bias, none is found by chance.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Array
    from rigrunner_bearings.compensations.bearing import Reversals

DRAWS = 64
"""Pairs of either sign: what they scatter by is a tenth of the bias."""

SEED = 0
"""The same recordings are to give the same result."""


def noise_bias(bearing_nm: Array, runs: Sequence[Array], where: Reversals) -> float:
    """Return by how much the starting torque of a mean curve, shape (n,), is raised by noise, N·m.

    `runs` has for each run the curve without each of its cycles in turn, shape (cycles, n).
    """
    index = np.concatenate([where.forward, where.backward])
    split = len(where.forward)
    here = type(where)(np.arange(split), np.arange(split, len(index)))
    rng, curve = np.random.default_rng(SEED), bearing_nm[index]
    errors = sum((_errors(each[:, index], rng) for each in runs), np.zeros((DRAWS, len(index))))
    both = here.torque(curve + errors) + here.torque(curve - errors)
    return float(np.mean(both) / 2 - here.torque(curve))


def _errors(without_each: Array, rng: np.random.Generator) -> Array:
    """Return errors as the mean over the cycles has them, shape (DRAWS, n), normal.

    What each cycle moves the mean by, with normal weights: their covariance is the jackknife's.
    """
    cycles = len(without_each)
    moved = (without_each - without_each.mean(axis=0)) * np.sqrt((cycles - 1) / cycles)
    return np.asarray(rng.standard_normal((DRAWS, cycles)) @ moved)
