"""The interval that holds the measurand with a given probability, by the shape of its distribution.

An uncertainty that a few bounded errors make up has no tails: k = 1.96 would hold more than 95 %
(GUM G.1.5, G.6.5). The fourth moments of the parts tell how far from normal their sum is, and a
distribution of Pearson's family with the same variance and kurtosis gives the factor (R. Willink,
Metrologia 42, 2005, 329).
"""

from __future__ import annotations

from functools import lru_cache
from math import isinf, sqrt
from typing import TYPE_CHECKING

import scipy

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.data import Estimate
    from rigrunner.api.verdict import Limits

P = 0.95  # of every expanded uncertainty that is stated
KURTOSIS = {"rectangular": -1.2, "triangular": -0.6, "arcsine": -1.5}
"""Excess kurtosis of bounded distributions by their names; of others it counts as 0."""
NEARLY_NORMAL = -1e-3
"""Excess kurtosis beyond which the sum counts as normal: k differs by less than 1e-4."""
FEW = 500.0
"""Degrees of freedom of a bounded sum, below which its tails count: from here on they change no
probability by more than 0.2 %, and those of stored runs stay."""
_SCORES = 1e-6, 8.0
"""Of a normal variable: beyond, its probability is 0.5 or 0 to a part in 10¹⁵."""


def excess_kurtosis(parts: Iterable[tuple[float, str]], u: float) -> float:
    """Return that of a combined u, from the independent parts (u, distribution) that make it up.

    Fourth cumulants add as variances do. What t-distributed parts add to the tails is left to the
    degrees of freedom.
    """
    if not u > 0:  # also where u is not known (nan)
        return 0.0
    return sum((part / u) ** 4 * KURTOSIS.get(name, 0.0) for part, name in parts if part > 0)


def factor(estimate: Estimate, p: float = P) -> float:
    """Return the coverage factor k of the two-sided interval value +/- k u."""
    # Student's t widens any shape of the sum; for a normal one the product is t itself.
    return _tails(estimate.dof, p) * _body(estimate.kurtosis, p)


def expanded(estimate: Estimate, p: float = P) -> float:
    """Return the expanded uncertainty U = k u, in the unit of the estimate (GUM 6.2.1)."""
    return factor(estimate, p) * estimate.u


def cumulative(estimate: Estimate, limit: float) -> float:
    """Return the probability that the true value is at most the limit (JCGM 106, 7).

    By the same distribution as `factor`: at value + k u it is (1 + p) / 2, exactly for p = 95 %.
    """
    if isinf(limit):
        return 1.0 if limit > 0 else 0.0
    z = (limit - estimate.value) / estimate.u
    if estimate.kurtosis > NEARLY_NORMAL:
        if isinf(estimate.dof):
            return float(scipy.special.ndtr(z))
        return float(scipy.special.stdtr(estimate.dof, z))
    shape = _beta_shape(estimate.kurtosis)
    if estimate.dof >= FEW:
        reach = sqrt(2 * shape + 1) * _tails(estimate.dof, P)
        # A bounded distribution has an end, and probability 0 or 1 beyond it.
        inside = min(max((1 + z / reach) / 2, 0.0), 1.0)
        return float(scipy.special.betainc(shape, shape, inside))
    # Few degrees of freedom give a bounded sum tails: by the score of which k is |z|.
    score = _score(estimate.kurtosis, estimate.dof, float(f"{abs(z):.13g}"))
    return float(scipy.special.ndtr(score if z > 0 else -score))


@lru_cache(maxsize=256)  # a rule asks several times for one distance from its limits
def _score(kurtosis: float, dof: float, k: float) -> float:
    """Return the value s of a normal variable with `factor` k for p = 2 ndtr(s) - 1."""
    shape = _beta_shape(kurtosis)

    def excess(score: float) -> float:
        below = float(scipy.special.ndtr(-score))  # not its complement, which rounds off the tail
        tails = -scipy.special.stdtrit(dof, below) / score
        place = scipy.special.betaincinv(shape, shape, below)
        return float(tails * (1 - 2 * place) * sqrt(2 * shape + 1)) - k

    least, most = _SCORES
    if excess(least) >= 0:
        return 0.0
    return most if excess(most) <= 0 else float(scipy.optimize.brentq(excess, least, most))


def probability_within(limits: Limits, estimate: Estimate) -> float:
    """Return the probability that the true value is within the limits (JCGM 106, 7).

    By the distribution that the coverage interval of the estimate has too; nothing else is known of
    the item beforehand.
    """
    if estimate.u == 0:
        return float(limits.margin(estimate.value) >= 0)
    return cumulative(estimate, limits.upper) - cumulative(estimate, limits.lower)


def _tails(dof: float, p: float) -> float:
    """Return by how much few degrees of freedom widen the interval (GUM G.3.4)."""
    if isinf(dof):
        return 1.0
    upper = (1 + p) / 2
    return float(scipy.special.stdtrit(dof, upper) / scipy.special.ndtri(upper))


def _body(kurtosis: float, p: float) -> float:
    """Return the factor of a distribution without tails: a symmetric beta, or the normal one."""
    if kurtosis > NEARLY_NORMAL:
        return float(scipy.special.ndtri((1 + p) / 2))
    shape = _beta_shape(kurtosis)
    place = scipy.special.betaincinv(shape, shape, (1 + p) / 2)
    return float((2 * place - 1) * sqrt(2 * shape + 1))


def _beta_shape(kurtosis: float) -> float:
    """Return a of the symmetric beta(a, a) on -1 to 1: excess -6/(2a + 3), variance 1/(2a + 1).

    beta(1, 1) is a rectangle, beta(1/2, 1/2) an arcsine. A little of anything else rounds off the
    arcsine's peaks, which the fourth moment hardly shows: by its beta an arcsine with a rectangle
    of a tenth would be held in 91.9 %. By the square root it is 94 % to 98 %.
    """
    flat, flattest = KURTOSIS["rectangular"], KURTOSIS["arcsine"]
    if kurtosis < flat:
        # Rounding can take a single arcsine a little below its -1.5.
        return (1 + sqrt(max(kurtosis - flattest, 0.0) / (flat - flattest))) / 2
    return (-6 / kurtosis - 3) / 2
