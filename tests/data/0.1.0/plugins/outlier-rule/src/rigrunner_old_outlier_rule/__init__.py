"""The outlier rule old_outlier_rule: what is far from the median."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field
from rigrunner.api.analysis import Rejection
from rigrunner.api.data import Array
from rigrunner.api.hooks import OutlierRuleRecord, hookimpl
from rigrunner.api.settings import Settings

api_version = 1
NAME = "old_outlier_rule"
LEAST = 5
"""Of fewer values, none can be called the odd one."""
NORMAL = 1.4826
"""The standard deviation of normal values over their median absolute deviation."""


class OldOutlierRuleSettings(Settings):
    """What a procedure may say of it."""

    limit: Annotated[float, Field(gt=0, strict=False)] = 3.5
    """Standard deviations from the median beyond which a value is rejected."""


@dataclass(frozen=True)
class OldOutlierRule:
    """Satisfies `rigrunner.api.analysis.OutlierRule`."""

    settings: OldOutlierRuleSettings

    def __call__(self, values: Array) -> Sequence[Rejection]:
        """Return what is rejected of values of shape (n,), in their order."""
        if len(values) < LEAST:
            return []
        off = np.abs(values - np.median(values))
        spread = NORMAL * float(np.median(off))
        if spread <= 0:
            return []
        limit, distance = self.settings.limit, off / spread
        return [
            Rejection(int(index), float(values[index]), NAME, float(distance[index]), limit)
            for index in np.flatnonzero(distance > limit)
        ]


@hookimpl
def rigrunner_outlier_rules() -> list[OutlierRuleRecord]:
    """Tell Rigrunner what is in this file."""
    return [
        OutlierRuleRecord(
            name=NAME,
            help="Old outlier rule: far from the median",
            settings=OldOutlierRuleSettings,
            factory=OldOutlierRule,
        )
    ]
