"""Rosner's generalized extreme studentized deviate test: several gross errors, also such as mask.

Rosner, Technometrics 25(2), 1983; NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.5.17.3. The
most extreme value is taken out again and again, up to a number chosen beforehand, and only then is
the last one looked for that exceeds its critical value: it is rejected with all before it. Two like
errors inflate the standard deviation, so that the first does not exceed; the repeated Grubbs' test
stops there. The critical value of the i-th is that of Grubbs for the n - i + 1 values then left.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice
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
    from rigrunner_plugins.outlier_rules.settings import GeneralizedEsdSettings


LEAST_PER_ERROR = 5
"""In a small sample the test rejects good values more often than alpha says, the more the more
errors it looks for; so it looks for one among five values at most."""


@dataclass(frozen=True)
class GeneralizedEsd:
    """The two-sided test; satisfies `rigrunner.api.analysis.OutlierRule`."""

    settings: GeneralizedEsdSettings

    def __call__(self, values: Array) -> list[Rejection]:
        """Return the rejections in values of shape (n,), the most extreme first.

        A masked one carries its own statistic, which need not exceed its critical value; that of
        the last one does.
        """
        at_most = max(1, min(self.settings.at_most, len(values) // LEAST_PER_ERROR))
        found = list(islice(suspects("generalized_esd", values, self._suspect), at_most))
        exceeding = [count for count, each in enumerate(found, 1) if exceeds(each)]
        return found[: max(exceeding, default=0)]

    def _suspect(self, sample: Array) -> Suspect | None:
        n = len(sample)
        if n < LEAST:
            return None
        distance = np.abs(studentized(sample))
        worst = int(distance.argmax())
        return Suspect(worst, float(distance[worst]), critical_value(n, self.settings.alpha))
