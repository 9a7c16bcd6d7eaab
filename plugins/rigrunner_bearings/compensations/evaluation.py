"""The starting torque of a pair of runs at the best estimates of all else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.compensations.bearing import (
    Reversals,
    bearing_torque,
    replicates,
    reversals,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Array
    from rigrunner_bearings.compensations.bearing import Pair, Reversals
    from rigrunner_bearings.compensations.identification import Identified


DRAWS = 64
"""Pairs of either sign: what they scatter by is a tenth of the bias."""

SEED = 0
"""The same recordings are to give the same result."""


def noise_bias(bearing_nm: Array, runs: Sequence[Array], reversals: Reversals) -> float:
    """Return by how much the starting torque of a mean curve, shape (n,), is raised by noise, N·m.

    `runs` has for each run the curve without each of its cycles in turn, shape (cycles, n).

    The greatest of several values that each err is on average too great. The cycles' deviations
    from their mean show how the mean curve errs; curves with such errors once more added show how
    much their maximum is raised (parametric bootstrap of the bias: Efron and Tibshirani, An
    Introduction to the Bootstrap, 10). Each error is taken with both signs, so that where the
    maximum is smooth, and has no bias, none is found by chance.
    """
    index = np.concatenate([reversals.forward, reversals.backward])
    split = len(reversals.forward)
    local = type(reversals)(np.arange(split), np.arange(split, len(index)))
    rng, curve = np.random.default_rng(SEED), bearing_nm[index]
    errors = sum((_errors(curves[:, index], rng) for curves in runs), np.zeros((DRAWS, len(index))))
    raised = local.torque(curve + errors) + local.torque(curve - errors)
    return float(np.mean(raised) / 2 - local.torque(curve))


def _errors(without_each: Array, rng: np.random.Generator) -> Array:
    """Return errors as the mean over the cycles has them, shape (DRAWS, n), normal.

    What each cycle moves the mean by, with normal weights: their covariance is the jackknife's.
    """
    cycles = len(without_each)
    moved = (without_each - without_each.mean(axis=0)) * np.sqrt((cycles - 1) / cycles)
    return np.asarray(rng.standard_normal((DRAWS, cycles)) @ moved)


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The torque of a pair, and what led to it."""

    pair: Pair
    bearing_nm: Array
    """Over the swing, shape (n,)."""
    reversals: Reversals
    without_each_nm: tuple[Array, Array]
    """The same without each cycle of the loaded and of the no-load run, shapes (cycles, n)."""
    maximum_nm: float
    """As it is read from the curve."""
    bias_nm: float
    """By how much noise raises it."""

    @property
    def torque_nm(self) -> float:
        """The result: the maximum less its bias."""
        return self.maximum_nm - self.bias_nm


def evaluate(rig: Identified, pair: Pair, window_rad: float) -> Evaluation:
    """Return the torque of a pair on the rig as it was learned."""
    line, friction = rig.line, rig.friction
    bearing = bearing_torque(line, friction, pair)
    at_reversals = reversals(line, friction, pair.loaded, window_rad)
    without_each = (
        replicates(line, bearing, pair.loaded, +1),
        replicates(line, bearing, pair.no_load, -1),
    )
    noisy = [
        curves
        for curves, run in zip(without_each, (pair.loaded, pair.no_load), strict=True)
        if run.of_cycles
    ]
    return Evaluation(
        pair=pair,
        bearing_nm=bearing,
        reversals=at_reversals,
        without_each_nm=without_each,
        maximum_nm=float(at_reversals.torque(bearing)),
        bias_nm=noise_bias(bearing, noisy, at_reversals),
    )
