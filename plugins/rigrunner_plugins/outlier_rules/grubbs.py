"""Grubbs' test for one gross error in normal values, repeated until it finds none.

Grubbs, Technometrics 11(1), 1969; ISO 5725-2, 7.3.4. Several gross errors of like size hide each
other from it; `generalized_esd` finds them.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import takewhile
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_plugins.outlier_rules.suspects import (
    LEAST,
    Suspect,
    critical_value,
    exceeds,
    studentized,
    suspects,
)

if TYPE_CHECKING:
    from rigrunner.api import Array, Rejection
    from rigrunner_plugins.outlier_rules.settings import GrubbsSettings


@dataclass(frozen=True)
class Grubbs:
    """The repeated test; satisfies `rigrunner.api.analysis.OutlierRule`."""

    settings: GrubbsSettings

    def __call__(self, values: Array) -> list[Rejection]:
        """Return the rejections in values of shape (n,), in the order in which they were made."""
        return list(takewhile(exceeds, suspects("grubbs", values, self._suspect)))

    def _suspect(self, sample: Array) -> Suspect | None:
        n = len(sample)
        if n < LEAST:
            return None
        distance = self._distance(studentized(sample))
        worst = int(distance.argmax())
        two_sided = self.settings.side == "both"
        critical = critical_value(n, self.settings.alpha, two_sided=two_sided)
        return Suspect(worst, float(distance[worst]), critical)

    def _distance(self, deviation: Array) -> Array:
        match self.settings.side:
            case "high":
                return deviation
            case "low":
                return -deviation
            case _:
                return np.abs(deviation)
