"""Grubbs' test for one gross error in normal values, repeated until it finds none.

Grubbs, Technometrics 11(1), 1969; ISO 5725-2, 7.3.4. Critical values come from Student's t, not
from a table.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import stdtrit

from rigrunner.api.analysis import Rejection

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rigrunner.api.data import Array
    from rigrunner_plugins.outlier_rules.settings import GrubbsSettings

LEAST = 3
"""Of two values none is the odd one."""

ROUNDING = 1e-12
"""Relative: a scatter that is no more than rounding makes no value the odd one."""


def critical_value(n: int, alpha: float, *, two_sided: bool = True) -> float:
    """Return the value that G exceeds with probability alpha in n >= 3 normal values.

    With t the quantile of Student's t with n - 2 degrees of freedom that alpha/n (two-sided:
    alpha/2n) exceeds: (n - 1)/sqrt(n) * sqrt(t^2/(n - 2 + t^2)).
    """
    tail = alpha / (2 * n if two_sided else n)
    t = float(stdtrit(n - 2, 1 - tail))
    return (n - 1) / sqrt(n) * sqrt(t**2 / (n - 2 + t**2))


@dataclass(frozen=True)
class Grubbs:
    """The repeated test; satisfies `rigrunner.api.analysis.OutlierRule`."""

    settings: GrubbsSettings

    def __call__(self, values: Array) -> list[Rejection]:
        """Return the rejections in values of shape (n,), in the order in which they were made."""
        rejections: list[Rejection] = []
        remaining = np.arange(len(values))
        while (rejection := self._worst(values, remaining)) is not None:
            rejections.append(rejection)
            remaining = remaining[remaining != rejection.index]
        return rejections

    def _worst(self, values: Array, remaining: NDArray[np.intp]) -> Rejection | None:
        if len(remaining) < LEAST:
            return None
        sample = values[remaining]
        s = sample.std(ddof=1)
        if s <= ROUNDING * np.abs(sample).max():
            return None
        distance = self._distance(sample - sample.mean())
        worst = int(distance.argmax())
        statistic = float(distance[worst] / s)
        two_sided = self.settings.side == "both"
        critical = critical_value(len(sample), self.settings.alpha, two_sided=two_sided)
        if statistic <= critical:
            return None
        index = int(remaining[worst])
        return Rejection(index, float(values[index]), "grubbs", statistic, critical)

    def _distance(self, deviation: Array) -> Array:
        match self.settings.side:
            case "high":
                return deviation
            case "low":
                return -deviation
            case _:
                return np.abs(deviation)
