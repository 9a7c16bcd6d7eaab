"""The peaks of a prepared set-point as the peak methods read them."""

from __future__ import annotations

from math import isnan, nan
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Estimate, Points
from rigrunner.signal.inputs import scattered, unknown
from rigrunner.signal.repeatability import standard_error

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Effect
    from rigrunner_bearings.api.points import PeakPoint


def mean_peak(point: PeakPoint) -> Estimate:
    """Return the mean of the kept raw peaks in N·m, and its type A uncertainty (GUM 4.2).

    A single value shows no scatter: then uncertainty and degrees of freedom are nan.
    """
    values = point.peak_nm[point.peak_kept]
    if len(values) == 1:
        return Estimate(float(values[0]), nan, nan)
    return Estimate(float(values.mean()), *standard_error(values))


def scatter_effect(name: str, peak: Estimate) -> Effect:
    """Return the scatter of a mean peak as an input; unknown, where a single value showed none."""
    return unknown(name) if isnan(peak.u) else scattered(name, peak.u, peak.dof)


def peak_points(points: Sequence[PeakPoint]) -> Points:
    """Return the mean peaks over the measured frequency.

    With their type A uncertainty, unless that of one of them is unknown.
    """
    peaks = [mean_peak(point) for point in points]
    u = np.array([peak.u for peak in peaks])
    return Points(
        x=np.array([point.frequency_hz.value for point in points]),
        y=np.array([peak.value for peak in peaks]),
        u_y=None if np.isnan(u).any() else u,
    )
