"""Statistics of values: each with its value, its scatter and its sensitivity to reading errors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import TYPE_CHECKING

import numpy as np
import scipy

from rigrunner.api import DataError
from rigrunner.signal.effective_samples import effective_number, mean_error

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api import Array

LEAST_FOR_SLOPE = 3
_BY_CHANCE = 0.05
"""That recordings of one value are taken to differ."""


@dataclass(frozen=True, eq=False)
class Series:
    """The values of a group, shape (n,), in the order in which they were measured."""

    values: Array
    times_s: Array
    """Time of each value on one clock in s, shape (n,)."""
    in_a_row: bool
    """Whether they are samples of recordings, which may be autocorrelated."""
    step_s: float = 0.0
    """Time between two samples of a recording in s."""
    starts: tuple[int, ...] = ()
    """The index at which each recording but the first begins."""

    @property
    def from_first(self) -> Array:
        """The values less the first, shape (n,): equal ones scatter by no rounding error."""
        return np.asarray(self.values - self.values[0])


Scatter = tuple[float, float]
"""A standard uncertainty of type A and its degrees of freedom."""


@dataclass(frozen=True)
class Statistic:
    """A statistic of a series."""

    value: Callable[[Series], float]
    scatter: Callable[[Series], Scatter | None]
    """Type A uncertainty; None if the values do not show one."""
    bound: Callable[[Series, Array], float]
    """Greatest change caused by errors of the values, each within ± its own limit, shape (n,); of a
    range, by that of one value."""


def mean_scatter(series: Series) -> Scatter | None:
    """Return s/sqrt(n) with n - 1 (GUM 4.2.3); for samples, with the effective number.

    For recordings that differ by more than their samples explain: that of their means.
    """
    n = len(series.values)
    if n < 2:  # noqa: PLR2004  (of one value there is no scatter)
        return None
    if series.in_a_row:
        return _between_recordings(series) or mean_error(series.from_first)
    return float(series.from_first.std(ddof=1)) / sqrt(n), n - 1.0


def _between_recordings(series: Series) -> Scatter | None:
    """Return the scatter of the mean from those of the recordings; None where these agree.

    They agree if their scatter about the common mean is no more than that within each of them
    explains, by the F-test of the analysis of variance at 5 % (GUM H.5.2.2).
    """
    parts = np.split(series.from_first, series.starts)
    if len(parts) < 2 or min(map(len, parts)) < 2:  # noqa: PLR2004  (of one there is no scatter)
        return None
    shares = np.array([len(each) for each in parts]) / len(series.values)
    means = np.array([each.mean() for each in parts])
    u_within, dof_within = np.array([mean_error(each) for each in parts]).T
    count = len(parts)
    between = float(np.sum((shares * (means - shares @ means)) ** 2)) * count / (count - 1)
    variances = (shares * u_within) ** 2
    within = float(variances.sum())
    if within == 0:
        return (sqrt(between), count - 1.0) if between else None
    dof = within**2 / float(np.sum(variances**2 / dof_within))
    apart = scipy.special.fdtrc(count - 1, dof, between / within) < _BY_CHANCE
    return (sqrt(between), count - 1.0) if apart else None


def _independent(series: Series) -> float:
    return effective_number(series.from_first) if series.in_a_row else float(len(series.values))


def _rms(series: Series) -> float:
    return sqrt(float(np.mean(series.values**2)))


def _rms_scatter(series: Series) -> Scatter | None:
    """Return the scatter of the mean square, propagated: d rms = d(mean square)/(2 rms)."""
    squares = replace(series, values=series.values**2)
    found, rms = mean_scatter(squares), _rms(series)
    return None if found is None or rms == 0 else (found[0] / (2 * rms), found[1])


def _deviation(series: Series) -> float:
    if len(series.values) < 2:  # noqa: PLR2004  (of one there is no scatter)
        raise DataError("the standard deviation of one value is not known")
    return float(series.from_first.std(ddof=1))


def _deviation_scatter(series: Series) -> Scatter | None:
    """Return s/sqrt(2 (n - 1)) for normal values (GUM E.4.3)."""
    dof = _independent(series) - 1
    return (_deviation(series) / sqrt(2 * dof), dof) if dof > 0 else None


def percentile(share: float) -> Statistic:
    """Return the value that a given share of all values does not exceed."""

    def scatter(series: Series) -> Scatter | None:
        """Return half the distance between the order statistics n p ± sqrt(n p q).

        For any distribution, the number of values below is binomial (David and Nagaraja, Order
        Statistics, 3rd edition, 7.1).
        """
        n = _independent(series)
        spread = sqrt(share * (1 - share) / n)
        if n < 2:  # noqa: PLR2004  (of one there is no scatter)
            return None
        ends = np.clip([share - spread, share + spread], 0, 1)
        low, high = np.quantile(series.values, ends)
        return float(high - low) / 2, n - 1

    def value(series: Series) -> float:
        return float(np.quantile(series.values, share))

    return Statistic(value, scatter, _greatest)


def settling_time(within: float) -> Statistic:
    """Return the time until a series stays within a band around its last value."""

    def value(series: Series) -> float:
        outside = np.flatnonzero(np.abs(series.values - series.values[-1]) > within)
        if not len(outside):
            return 0.0
        return float(series.times_s[outside[-1] + 1] - series.times_s[0])

    def scatter(series: Series) -> Scatter | None:
        """Return the scatter of a time known to one step (GUM F.2.2.1)."""
        return (series.step_s / sqrt(12), inf) if series.step_s else None

    return Statistic(value, scatter, lambda _, __: 0.0)


def _slope(series: Series) -> float:
    return float(_weights(series) @ series.from_first)


def _weights(series: Series) -> Array:
    """Return the weight of each value in the least-squares slope, shape (n,)."""
    from_middle = series.times_s - series.times_s.mean()
    square = float(from_middle @ from_middle)
    if square == 0:
        raise DataError("values that were all taken at one time have no slope")
    return np.asarray(from_middle / square)


def _slope_scatter(series: Series) -> Scatter | None:
    """Return the scatter of the slope from the residuals (GUM H.3), for their effective number."""
    n = len(series.values)
    if n < LEAST_FOR_SLOPE:
        return None
    weights = _weights(series)
    slope = float(weights @ series.from_first)
    line = series.from_first.mean() + slope * (series.times_s - series.times_s.mean())
    residuals = series.from_first - line
    used = effective_number(residuals) if series.in_a_row else float(n)
    dof = max(used - 2, 1.0)
    spread = sqrt(float(residuals @ residuals) / n * used / dof)
    return spread * sqrt(float(weights @ weights) * n / used), dof


def _greatest(_: Series, errors: Array) -> float:
    return float(errors.max())


def _none(_: Series) -> None:
    return None


STATISTICS = {
    "mean": Statistic(
        lambda series: float(series.values.mean()),
        mean_scatter,
        lambda _, errors: float(errors.mean()),
    ),
    "minimum": Statistic(lambda series: float(series.values.min()), _none, _greatest),
    "maximum": Statistic(lambda series: float(series.values.max()), _none, _greatest),
    "range": Statistic(lambda series: float(np.ptp(series.values)), _none, _greatest),
    "rms": Statistic(_rms, _rms_scatter, _greatest),
    "standard_deviation": Statistic(_deviation, _deviation_scatter, _greatest),
    "slope": Statistic(
        _slope, _slope_scatter, lambda series, errors: float(np.abs(_weights(series)) @ errors)
    ),
}
