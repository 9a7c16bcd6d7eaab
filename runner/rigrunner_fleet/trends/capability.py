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

_FAR = 300.0
"""From here on t scatters only by the standard deviation, to 2e-4, and SciPy is less accurate."""


def capability(
    values: Sequence[float],
    *,
    lower: float | None = None,
    upper: float | None = None,
    confidence: float = 0.95,
) -> Capability:
    """Return the indices of values, shape (n,), against one limit or two, in the same unit.

    The standard deviation is that of all values. Raises DataError without a limit, for limits
    that are not in order, for a single value, and for values that are all equal.
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
    half = float(special.stdtrit(x.size - 1, 0.5 + confidence / 2.0)) * deviation / sqrt(x.size)
    of_one = two_sided(1.0, x.size, confidence)
    return Capability(
        count=x.size,
        mean=mean,
        standard_deviation=deviation,
        confidence=confidence,
        indices=(*overall, *sides),
        mean_interval=(mean - half, mean + half),  # JCGM 100:2008, 4.2.3 and G.3.2
        deviation_interval=(deviation / of_one.high, deviation / of_one.low),
    )


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
    low, high = (float(special.nctdtrinc(count - 1, p, t)) for p in (1.0 - tail, tail))
    return Index(name, value, low / (3.0 * sqrt(count)), high / (3.0 * sqrt(count)))


def _check(count: int, lower: float | None, upper: float | None) -> None:
    if lower is None and upper is None:
        raise DataError("a capability needs a limit", hint="give an upper or a lower one, or both")
    if lower is not None and upper is not None and not lower < upper:
        raise DataError(f"the lower limit, {lower:g}, is not below the upper one, {upper:g}")
    if count < 2:  # noqa: PLR2004  (a single value has no standard deviation)
        raise DataError(f"{count} value is too few for a capability", hint="give at least 2")
