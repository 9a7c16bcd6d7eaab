"""The peaks of a prepared set-point as the peak methods read them."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.analysis import Component
from rigrunner.api.data import Points

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.analysis import PeakPoint


def mean_peak(point: PeakPoint) -> tuple[float, tuple[Component, ...]]:
    """Return the mean of the kept raw peaks in N·m, and its type A uncertainty (GUM 4.2).

    A single value shows no scatter: then the uncertainty is unknown, and there is no component.
    """
    values = point.peak_nm[point.peak_kept]
    if len(values) == 1:
        return float(values[0]), ()
    u = float(values.std(ddof=1)) / sqrt(len(values))
    scatter = Component("scatter between cycles", u, float(len(values) - 1), "t", common=False)
    return float(values.mean()), (scatter,)


def peak_points(points: Sequence[PeakPoint]) -> Points:
    """Return the mean peaks over the measured frequency.

    With their type A uncertainty, unless that of one of them is unknown.
    """
    peaks = [mean_peak(point) for point in points]
    u = [part.u for _, scatter in peaks for part in scatter]
    return Points(
        x=np.array([point.frequency_hz.value for point in points]),
        y=np.array([value for value, _ in peaks]),
        u_y=np.array(u) if len(u) == len(peaks) else None,
    )
