"""The 3-sigma rule, named after Pauta or Wright, repeated until it finds none.

It takes the sample's own standard deviation for sigma. In n values no deviation can be more than
(n - 1)/sqrt(n) of these (Shiffler, The American Statistician 42(1), 1988), which is below 3 up to
n = 10: there the rule can reject nothing, whatever the values, and is refused.
"""

from __future__ import annotations

from itertools import takewhile
from math import sqrt
from typing import TYPE_CHECKING, Final

import numpy as np

from rigrunner.api import DataError
from rigrunner_plugins.outlier_rules.requirements import BLIND_OF_PAUTA
from rigrunner_plugins.outlier_rules.suspects import Suspect, exceeds, studentized, suspects

if TYPE_CHECKING:
    from rigrunner.api import Array, Rejection

CRITICAL: Final = 3.0


def pauta(values: Array) -> list[Rejection]:
    """Return the rejections in values of shape (n,), worst first; DataError for n <= 10."""
    n = len(values)
    if n <= BLIND_OF_PAUTA:
        reach = f": no deviation can exceed (n - 1)/√n = {(n - 1) / sqrt(n):.2f}" if n > 1 else ""
        raise DataError(
            f"pauta, the 3-sigma rule, can reject none of {n} values{reach}",
            hint=f"record more than {BLIND_OF_PAUTA} cycles, or use grubbs",
        )
    return list(takewhile(exceeds, suspects("pauta", values, _suspect)))


def _suspect(sample: Array) -> Suspect:
    distance = np.abs(studentized(sample))
    worst = int(distance.argmax())
    return Suspect(worst, float(distance[worst]), CRITICAL)
