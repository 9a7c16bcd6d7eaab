"""The modified z-score: distance from the median in median absolute deviations.

Iglewicz and Hoaglin, How to Detect and Handle Outliers, 1993; NIST/SEMATECH e-Handbook of
Statistical Methods, 1.3.5.17. Median and MAD are not moved by the gross errors themselves, up to
half of the values. The threshold 3.5 is theirs, a recommendation and no risk: of few normal values
it rejects one more often than of many.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from typing import TYPE_CHECKING, Final

import numpy as np
from scipy.special import ndtri

from rigrunner.api import Rejection
from rigrunner_plugins.outlier_rules.suspects import LEAST, ROUNDING

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_plugins.outlier_rules.settings import MadSettings

SIGMA_PER_MAD: Final = 1 / float(ndtri(0.75))
"""Of the normal distribution: half of it lies within 0.6745 standard deviations."""

# Of the normal distribution, whose mean absolute deviation is sqrt(2/pi) sigma.
SIGMA_PER_MEAN_DEVIATION: Final = sqrt(pi / 2)


@dataclass(frozen=True)
class Mad:
    """The rule, applied once; satisfies `rigrunner.api.analysis.OutlierRule`."""

    settings: MadSettings

    def __call__(self, values: Array) -> list[Rejection]:
        """Return the rejections in values of shape (n,), in their order."""
        if len(values) < LEAST:
            return []
        score, critical = modified_z_score(values), self.settings.threshold
        return [
            Rejection(int(index), float(values[index]), "mad", float(score[index]), critical)
            for index in np.flatnonzero(score > critical)
        ]


def modified_z_score(values: Array) -> Array:
    """Return the distances (n,) from the median in robust standard deviations.

    Where more than half of the values are one and the same, their MAD is zero and their mean
    absolute deviation takes its place; zeros where that, too, is rounding.
    """
    distance = np.abs(values - np.median(values))
    rounding = ROUNDING * np.abs(values).max()
    sigma = SIGMA_PER_MAD * float(np.median(distance))
    if sigma <= rounding:
        sigma = SIGMA_PER_MEAN_DEVIATION * float(distance.mean())
    if sigma <= rounding:
        return np.zeros_like(distance)
    score: Array = distance / sigma
    return score
