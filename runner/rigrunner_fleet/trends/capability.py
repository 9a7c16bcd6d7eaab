"""Capability of a process against its limits, with confidence intervals.

ISO 22514-2; the interval of Cp by chi-square, that of a one-sided index exact by the non-central
t distribution, that of Cpk after Bissell, Appl. Stat. 39 (1990) 331-340.
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np
from scipy import special

from rigrunner.api.errors import DataError
from rigrunner.api.studies import Capability, Index

if TYPE_CHECKING:
    from collections.abc import Sequence

_BRACKET = 6.0
"""Standard deviations of t within which its non-centrality is searched."""
_FAR = 3000.0
"""From here on t scatters only by the standard deviation, and SciPy's cdf becomes NaN."""


def capability(
    values: Sequence[float],
    *,
    lower: float | None = None,
    upper: float | None = None,
    confidence: float = 0.95,
) -> Capability:
    """Return the indices of values, shape (n,), against one limit or two, in the same unit.

    The standard deviation is that of all values. Raises DataError without a limit, for limits
    that are not in order, for fewer than ten values, and for values that are all equal.
    """
    x = np.asarray(values, dtype=np.float64)
    _check(x.size, lower, upper)
    mean, deviation = float(x.mean()), float(x.std(ddof=1))
    if np.ptp(x) == 0.0:  # the deviation of equal values may be a rounding error
        raise DataError("the values are all the same: no capability can be stated")
    sides = []
    if upper is not None:
        sides.append(one_sided("Cpu", (upper - mean) / (3.0 * deviation), x.size, confidence))
    if lower is not None:
        sides.append(one_sided("Cpl", (mean - lower) / (3.0 * deviation), x.size, confidence))
    overall: list[Index] = []
    if lower is not None and upper is not None:
        ratio = (upper - lower) / (6.0 * deviation)
        least = min(index.value for index in sides)
        overall = [two_sided(ratio, x.size, confidence), smaller(least, x.size, confidence)]
    return Capability(x.size, mean, deviation, confidence, (*overall, *sides))


def two_sided(cp: float, count: int, confidence: float) -> Index:
    """Return Cp with its interval, exact for normal values: by quantiles of chi squared."""
    tail = (1.0 - confidence) / 2.0
    half = (count - 1) / 2.0
    low, high = (sqrt(special.gammaincinv(half, p) / half) for p in (tail, 1.0 - tail))
    return Index("Cp", cp, cp * low, cp * high)


def smaller(cpk: float, count: int, confidence: float) -> Index:
    """Return Cpk with Bissell's interval, which is approximate."""
    z = float(special.ndtri(0.5 + confidence / 2.0))
    half = z * sqrt(1.0 / (9.0 * count) + cpk**2 / (2.0 * (count - 1)))
    return Index("Cpk", cpk, cpk - half, cpk + half)


def one_sided(name: str, value: float, count: int, confidence: float) -> Index:
    """Return Cpu or Cpl with its interval, exact for normal values.

    3 sqrt(n) times the index follows a non-central t distribution with n - 1 degrees of freedom
    and the non-centrality 3 sqrt(n) times the true index.
    """
    tail = (1.0 - confidence) / 2.0
    t = 3.0 * sqrt(count) * value
    if abs(t) > _FAR:
        far = two_sided(value, count, confidence)
        return Index(name, value, min(far.low, far.high), max(far.low, far.high))
    # The less probable a t as small as this one, the greater is the non-centrality.
    low, high = (_non_centrality(t, count - 1, p) for p in (1.0 - tail, tail))
    return Index(name, value, low / (3.0 * sqrt(count)), high / (3.0 * sqrt(count)))


def _non_centrality(t: float, dof: int, probability: float) -> float:
    """Return the non-centrality at which t is reached with that probability."""
    from scipy import optimize, stats  # noqa: PLC0415  (heavy, and needed here alone)

    def difference(delta: float) -> float:
        return float(stats.nct.cdf(t, dof, delta)) - probability

    reach = _BRACKET * sqrt(1.0 + t**2 / (2.0 * dof))  # farther out, SciPy's cdf ends in NaN
    return float(optimize.brentq(difference, t - reach, t + reach, xtol=1e-10))


def _check(count: int, lower: float | None, upper: float | None) -> None:
    if lower is None and upper is None:
        raise DataError("a capability needs a limit", hint="give an upper or a lower one, or both")
    if lower is not None and upper is not None and not lower < upper:
        raise DataError(f"the lower limit, {lower:g}, is not below the upper one, {upper:g}")
    if count < 10:  # noqa: PLR2004  (below, the interval spans more than a factor of two)
        raise DataError(f"{count} values are too few for a capability", hint="give at least 10")
