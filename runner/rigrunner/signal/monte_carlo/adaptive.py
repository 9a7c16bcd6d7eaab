"""The adaptive Monte Carlo procedure (JCGM 101:2008, 7.9.4): blocks until the results stay.

Every block has a random stream of its own, which follows from seed and block number alone. So the
same seed gives the same values in any number of blocks, and each further block only adds.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import DataError
from rigrunner.signal.monte_carlo.intervals import (
    Interval,
    intervals,
    numerical_tolerance,
    ranked,
    symmetric,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.random import Generator

    from rigrunner.api.data import Array

BLOCK = 10_000
"""Trials, the least that 7.9.4 b) allows: 100/(1 - p) is fewer for p up to 0.99."""


@dataclass(frozen=True, kw_only=True)
class Adaptive:
    """How long to continue.

    The results are stable to `tolerance_share` of the numerical tolerance: 1 for a result of its
    own, a fifth where it is to check another (8.2).
    """

    digits: int = 2
    least_trials: int = 1_000_000
    most_trials: int = 10_000_000
    tolerance_share: float = 0.2
    p: float = 0.95
    seed: int = 1


@dataclass(frozen=True)
class Propagated:
    """The output quantity as its distribution shows it."""

    trials: int
    mean: float
    u: float
    symmetric: Interval
    shortest: Interval
    tolerance: float
    """Half of the last digit that matters of u."""
    stable: bool
    """False if most_trials did not suffice for the share of the tolerance."""


def propagate(output: Callable[[Generator, int], Array], how: Adaptive) -> Propagated:
    """Return what `output(rng, n)`, values of shape (n,), is distributed like.

    Raises DataError for values that are not finite.
    """
    blocks: list[Array] = []
    statistics: list[tuple[float, ...]] = []
    for block in _blocks(output, how.seed):
        blocks.append(ranked(block, how.p))
        statistics.append(_statistics(block, symmetric(blocks[-1], how.p)))
        trials = len(blocks) * BLOCK
        if trials < how.least_trials or len(blocks) == 1:  # a single block has no scatter
            continue
        tolerance = how.tolerance_share * numerical_tolerance(_pooled_u(statistics), how.digits)
        # Stable: twice the deviation of each mean over the blocks is within the tolerance.
        u_of_means = np.std(statistics, axis=0, ddof=1) / sqrt(len(statistics))
        stable = bool(np.all(2 * u_of_means <= tolerance))
        if stable or trials >= how.most_trials:
            break
    means, deviations = np.array(statistics)[:, :2].T
    mean = float(means.mean())
    squares = (BLOCK - 1) * (deviations**2).sum() + BLOCK * ((means - mean) ** 2).sum()
    u = sqrt(squares / (trials - 1))
    coverage = intervals(blocks, how.p)
    return Propagated(
        trials=trials,
        mean=mean,
        u=u,
        symmetric=coverage.symmetric,
        shortest=coverage.shortest,
        tolerance=numerical_tolerance(u, how.digits),
        stable=stable,
    )


def _blocks(output: Callable[[Generator, int], Array], seed: int) -> Iterator[Array]:
    for number in count():
        rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
        values = np.asarray(output(rng, BLOCK))
        if not np.isfinite(values).all():
            raise DataError(
                f"the measurement equation gives no finite value in {np.sum(~np.isfinite(values))} "
                f"of {BLOCK} Monte Carlo trials",
                hint="a quotient whose divisor may be zero has no standard uncertainty",
            )
        yield values


def _statistics(values: Array, interval: Interval) -> tuple[float, ...]:
    """Return mean, standard deviation and both ends of the interval of a block (7.9.4 e).

    The interval is the symmetric one: of the shortest, the ends wander where the density is flat.
    """
    mean = float(values.mean())
    deviation = values - mean
    u = sqrt(float(deviation @ deviation) / (len(values) - 1))
    return mean, u, interval.low, interval.high


def _pooled_u(statistics: list[tuple[float, ...]]) -> float:
    """Return the standard deviation of all values, from those of equal blocks (7.9.4 i)."""
    means, deviations = np.array(statistics)[:, :2].T
    return float(np.sqrt(np.mean(deviations**2) + means.var()))
