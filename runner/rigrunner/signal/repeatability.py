"""The uncertainty of a mean over cycles that follow each other, and may not be independent.

Cycles in a row share what is slow: a drifting zero, a load that hunts, a part that warms up. The
standard deviation over sqrt(n) then takes them for more information than they are. Where the
scatter shows a correlation from one cycle to the next, it is taken to be that of a first-order
autoregressive process x_i = phi x_(i-1) + noise, of which the variance of the mean is known (Zhang,
Metrologia 43, 2006, S276):

    u^2 = sigma^2/n g,   g = (1 + phi)/(1 - phi) - 2 phi (1 - phi^n)/(n (1 - phi)^2)

n/g is the effective number of independent cycles.
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np
import scipy

if TYPE_CHECKING:
    from rigrunner.api.data import Array

LEAST = 8
"""Fewest cycles from which a correlation is estimated."""

CHANCE = 0.1
"""Probability that independent cycles are taken for correlated ones."""

GREATEST = 0.95
"""Of phi: nearer to 1 the cycles show no mean."""


def standard_error(values: Array) -> tuple[float, float]:
    """Return the standard uncertainty of a mean of successive values (n,), and its dof.

    Type A (GUM 4.2.3), widened where the values are correlated; then the degrees of freedom are
    those of the effective number of independent values. n must be 2 at least.
    """
    n = len(values)
    # Correlated values scatter less: on average s^2 is sigma^2 (n - inflation)/(n - 1).
    inflation = n / effective_number(values)
    variance = float(values.var(ddof=1)) * (n - 1) / (n - inflation)
    return sqrt(variance * inflation / n), max(n / inflation - 1, 1.0)


def jackknife_error(replicates: Array, *, in_a_row: bool = True) -> tuple[float, float]:
    """Return the same of any smooth statistic of a mean over cycles, from leave-one-out values.

    Shape (n,), in the order of the cycles. What each cycle moves the statistic by takes the place
    of the values (Efron and Stein, Ann. Statist. 9(3), 1981). What does not follow each other in
    time is taken to be independent.
    """
    n, changes = len(replicates), influences(replicates)
    return standard_error(changes) if in_a_row else (float(changes.std(ddof=1)) / sqrt(n), n - 1.0)


def influences(replicates: Array) -> Array:
    """Return what each cycle moves a statistic by, shape (n,), from its leave-one-out values.

    Their mean is 0; of a mean of values they are the values less it.
    """
    return np.asarray((1 - len(replicates)) * (replicates - replicates.mean()))


def effective_number(values: Array, chance: float = CHANCE) -> float:
    """Return the effective number of independent values, for the mean of these (n,); n at most.

    `chance` is that of independent values to be taken for fewer.
    """
    n, phi = len(values), autocorrelation(values, chance)
    if phi == 0:
        return float(n)
    inflation = (1 + phi) / (1 - phi) - 2 * phi * (1 - phi**n) / (n * (1 - phi) ** 2)
    # With 1 the correction of the variance in `standard_error` would divide by 0.
    return max(n / inflation, 1.5)


def autocorrelation(values: Array, chance: float = CHANCE) -> float:
    """Return phi, from one value to the next; 0 unless it is positive and more than chance.

    The lag-one coefficient r of a short series is too small by (1 + 4 phi)/n (Marriott and Pope,
    Biometrika 41, 1954); of independent values it scatters by 1/sqrt(n).
    """
    n, deviation = len(values), values - values.mean()
    total = float(deviation @ deviation)
    if n < LEAST or total == 0:
        return 0.0
    r = float(deviation[1:] @ deviation[:-1]) / total
    # Of independent values r is -1/n on average, not 0: phi = 0 in the formula above.
    if r + 1 / n < float(scipy.special.ndtri(1 - chance)) / sqrt(n):
        return 0.0
    # phi, from r = phi - (1 + 4 phi)/n
    return float(np.clip((n * r + 1) / (n - 4), 0.0, GREATEST))
