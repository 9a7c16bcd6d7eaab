"""What the rules share that take the most extreme value first, then that of the rest."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.special import stdtrit

from rigrunner.api import Rejection

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.api import Array

LEAST = 3
"""Of two values none is the odd one."""

ROUNDING = 1e-14
"""Relative, some forty times that of a number: where no more than this scatters, none is odd."""


class Suspect(NamedTuple):
    """The position in a sample of its most extreme value, with the numbers that judge it."""

    position: int
    statistic: float
    critical: float


def suspects(
    rule: str, values: Array, judge: Callable[[Array], Suspect | None]
) -> Iterator[Rejection]:
    """Yield the suspect of values of shape (n,), then that of those left, until there is none."""
    remaining = np.arange(len(values))
    while (found := judge(values[remaining])) is not None:
        index = int(remaining[found.position])
        yield Rejection(index, float(values[index]), rule, found.statistic, found.critical)
        remaining = np.delete(remaining, found.position)


def exceeds(rejection: Rejection) -> bool:
    """Say whether a suspect's statistic is beyond its critical value."""
    return rejection.statistic > rejection.critical


def studentized(sample: Array) -> Array:
    """Return (x - mean)/s of a sample of shape (n,), n >= 2; zeros where only rounding scatters."""
    s = sample.std(ddof=1)
    if s <= ROUNDING * np.abs(sample).max():
        return np.zeros_like(sample)
    deviation: Array = (sample - sample.mean()) / s
    return deviation


def critical_value(n: int, alpha: float, *, two_sided: bool = True) -> float:
    """Return what the largest studentized deviate of n >= 3 normal values exceeds with risk alpha.

    Grubbs, Technometrics 11(1), 1969. With t the quantile of Student's t with n - 2 degrees of
    freedom that alpha/n (two-sided: alpha/2n) exceeds: (n - 1)/sqrt(n) * sqrt(t^2/(n - 2 + t^2)).
    """
    tail = alpha / (2 * n if two_sided else n)
    t = -float(stdtrit(n - 2, tail))
    return (n - 1) / sqrt(n) / sqrt(1 + (n - 2) / t / t)
