"""Chauvenet's criterion, applied once.

Taylor, An Introduction to Error Analysis, chapter 6: a value is rejected if fewer than half a value
of n is expected to lie as far from the mean. So of normal values, too, about one sample in three
loses one; repeated, the rule would go on eating them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.special import ndtri

from rigrunner.api import Rejection
from rigrunner_plugins.outlier_rules.suspects import LEAST, studentized

if TYPE_CHECKING:
    from rigrunner.api import Array


def critical_value(n: int) -> float:
    """Return the deviation, in standard deviations, that half a value of n is expected beyond."""
    return -float(ndtri(1 / (4 * n)))


def chauvenet(values: Array) -> list[Rejection]:
    """Return the rejections in values of shape (n,), in their order; of n < 5 there are none."""
    n = len(values)
    if n < LEAST:
        return []
    distance, critical = np.abs(studentized(values)), critical_value(n)
    return [
        Rejection(int(index), float(values[index]), "chauvenet", float(distance[index]), critical)
        for index in np.flatnonzero(distance > critical)
    ]
