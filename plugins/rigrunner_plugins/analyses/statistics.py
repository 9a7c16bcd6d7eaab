"""Statistics of values: each with its value, its scatter and its sensitivity to reading errors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations
from math import inf, nan, sqrt
from typing import TYPE_CHECKING

import numpy as np
import scipy

from rigrunner.api import DataError
from rigrunner.signal.effective_samples import effective_number, mean_error

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rigrunner.api import Array

LEAST_FOR_SLOPE = 3
"""A line goes through two values: what they scatter about it is not known."""
LEAST_LEVELS = 3
"""Of a label, by which readings scatter."""
LONG = 5
"""How many times as long as both its neighbours an interval is where something is missing."""
_BY_CHANCE = 0.05
"""That recordings of one value are taken to differ."""
_TAIL = 0.025
"""Of a probability of 95 % on each side."""


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
    labels: tuple[tuple[int, ...], ...] = ()
    """Of single readings: for each label or counter with several values, which one each has."""

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

    For recordings that differ by more than their samples explain: that of their means. So it is for
    readings by a label with three values or more, such as specimens: the greatest of all labels
    that show levels. Two values, such as rising and falling, may differ on purpose.
    """
    n = len(series.values)
    if n < 2:  # noqa: PLR2004  (of one value there is no scatter)
        return None
    if series.in_a_row:
        return _between_recordings(series) or mean_error(series.from_first)
    levels = [
        _between(
            [series.from_first[np.equal(label, level)] for level in set(label)], _error_of_rows
        )
        for label in series.labels
        if len(set(label)) >= LEAST_LEVELS
    ]
    return max([_error_of_rows(series.from_first), *filter(None, levels)])


def _error_of_rows(values: Array) -> Scatter:
    n = len(values)
    return float(values.std(ddof=1)) / sqrt(n), n - 1.0


def correlation_of_means(series: Sequence[Series]) -> Array:
    """Return the correlation of the means of n series that were read together, shape (n, n).

    Of single readings it is that of the readings (GUM 5.2.3). Samples may be correlated at once and
    not over longer times, or the reverse: of recordings it is
    (u^2(a + b) - u^2(a - b))/(u^2(a + b) + u^2(a - b)), with a and b in units of their u.
    """
    if not series[0].in_a_row:
        return np.corrcoef([one.values for one in series])
    r = np.eye(len(series))
    scaled = [one.from_first / (mean_scatter(one) or (1.0,))[0] for one in series]
    for i, j in combinations(range(len(series)), 2):
        sum_scatter, difference_scatter = (
            mean_scatter(replace(series[i], values=scaled[i] + sign * scaled[j]))
            for sign in (1, -1)
        )
        if sum_scatter and difference_scatter:
            sum_, difference = sum_scatter[0] ** 2, difference_scatter[0] ** 2
            r[i, j] = r[j, i] = (sum_ - difference) / (sum_ + difference)
    lowest = float(np.linalg.eigvalsh(r)[0])  # pair by pair they need not fit together
    return (r - lowest * np.eye(len(r))) / (1 - lowest) if lowest < 0 else r


def _between_recordings(series: Series) -> Scatter | None:
    """Return the scatter of the mean from those of the recordings; None where these agree."""
    return _between(np.split(series.from_first, series.starts), mean_error)


def _between(parts: Sequence[Array], error: Callable[[Array], Scatter]) -> Scatter | None:
    """Return the scatter of the mean of all parts from that of their means; None where these agree.

    They agree if their scatter about the common mean is no more than that within each of them
    explains, by the F-test of the analysis of variance at 5 % (GUM H.5.2.2). `error` gives the
    scatter of the mean of one part.
    """
    if len(parts) < 2 or min(map(len, parts)) < 2:  # noqa: PLR2004  (of one there is no scatter)
        return None
    shares = np.array([len(part) for part in parts]) / sum(map(len, parts))
    means = np.array([part.mean() for part in parts])
    u_within, dof_within = np.array([error(part) for part in parts]).T
    count = len(parts)
    between = float(np.sum((shares * (means - shares @ means)) ** 2)) * count / (count - 1)
    variances = (shares * u_within) ** 2
    within = float(variances.sum())
    if within == 0:
        return (sqrt(between), count - 1.0) if between else None
    dof = within**2 / float(np.sum(variances**2 / dof_within))
    differ = scipy.special.fdtrc(count - 1, dof, between / within) < _BY_CHANCE
    return (sqrt(between), count - 1.0) if differ else None


def _independent_count(series: Series) -> float:
    """Return the effective number of values; of recordings that differ in level: their number."""
    if not series.in_a_row:
        return float(len(series.values))
    if _between_recordings(series):
        return len(series.starts) + 1.0
    return effective_number(series.from_first)


def _rms(series: Series) -> float:
    return sqrt(float(np.mean(series.values**2)))


def _rms_scatter(series: Series) -> Scatter | None:
    """Return the scatter of the mean square, propagated: d rms = d(mean square)/(2 rms)."""
    squares = replace(series, values=series.values**2)
    scatter, rms = mean_scatter(squares), _rms(series)
    return None if scatter is None or rms == 0 else (scatter[0] / (2 * rms), scatter[1])


def _deviation(series: Series) -> float:
    if len(series.values) < 2:  # noqa: PLR2004  (of one there is no scatter)
        raise DataError("the standard deviation of one value is not known")
    return float(series.from_first.std(ddof=1))


def _deviation_scatter(series: Series) -> Scatter | None:
    """Return s/sqrt(2 (n - 1)) for normal values (GUM E.4.3)."""
    dof = _independent_count(series) - 1
    return (_deviation(series) / sqrt(2 * dof), dof) if dof > 0 else None


def percentile(share: float) -> Statistic:
    """Return the value that a given share of all values does not exceed."""

    def scatter(series: Series) -> Scatter | None:
        """Return U/k of the 95 % interval between order statistics; nan of too few values.

        For any distribution, the number of values below is binomial (David and Nagaraja, Order
        Statistics, 3rd edition, 7.1): a share is below the largest of n by chance p^n. U is the
        greater distance of an end from the value.
        """
        n = _independent_count(series)
        if n < 2:  # noqa: PLR2004  (of one there is no scatter)
            return None
        if max(share, 1 - share) ** n > _TAIL:
            return nan, n - 1
        below, above = n * share, n * (1 - share)
        ends = (
            scipy.special.betaincinv(below, above + 1, _TAIL),
            scipy.special.betaincinv(below + 1, above, 1 - _TAIL),
        )
        low, high = np.quantile(series.values, ends)
        at = value(series)
        return max(at - low, high - at) / scipy.special.stdtrit(n - 1, 1 - _TAIL), n - 1

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
    levels = _levels_about_a_line(series, weights)
    if levels is not None:
        return levels
    slope = float(weights @ series.from_first)
    line = series.from_first.mean() + slope * (series.times_s - series.times_s.mean())
    residuals = series.from_first - line
    independent = effective_number(residuals) if series.in_a_row else float(n)
    dof = max(independent - 2, 1.0)
    spread = sqrt(float(residuals @ residuals) / n * independent / dof)
    return spread * sqrt(float(weights @ weights) * n / independent), dof


def _levels_about_a_line(series: Series, weights: Array) -> Scatter | None:
    """Return the scatter of the slope from the levels of recordings; None where they show none.

    They do by the F-test at 5 % of a line against parallel lines, one for each recording. A level b
    moves the slope by the sum W of its recording's weights, so u^2 = s_b^2 sum(W^2), with m - 2
    degrees of freedom; s_b^2 is the sum of the squared mean residuals over what levels of variance
    1 make of it. What scatters within the recordings is added. Through two levels there is always
    a line, so u is not known of two recordings.
    """
    sizes = np.diff([0, *series.starts, len(series.values)])
    count = len(sizes)
    if not series.in_a_row or count < 2 or sizes.min() < 2:  # noqa: PLR2004  (one has no slope)
        return None
    if count == 2:  # noqa: PLR2004  (a line goes through two)
        return nan, 1.0
    recording = np.repeat(np.arange(count), sizes)

    def means(values: Array) -> Array:
        return np.asarray(np.bincount(recording, values) / sizes)

    times = series.times_s - series.times_s.mean()
    line = float(weights @ series.from_first) * times
    residuals = series.from_first - series.from_first.mean() - line
    centred = times - means(times)[recording]
    within = series.from_first - means(series.from_first)[recording]
    within = within - float(centred @ within) / float(centred @ centred) * centred
    number = effective_number(within)
    dof = number - count - 1
    if dof <= 0:
        return None
    variance = float(within @ within) / len(within) * number / dof
    inflation = len(within) / number
    explained = float(residuals @ residuals - within @ within) / (count - 1)
    if explained <= 0 or (
        variance > 0
        and scipy.special.fdtrc(count - 1, dof, explained / (variance * inflation)) >= _BY_CHANCE
    ):
        return None
    pull = np.bincount(recording, weights)
    projection = np.eye(count) - sizes / len(within) - np.outer(means(times), pull)
    levels = float(np.sum(means(residuals) ** 2)) / float(np.sum(projection**2))
    noise = variance * inflation * float(weights @ weights)
    return sqrt(levels * float(pull @ pull) + noise), count - 2.0


def why_no_integral(series: Series) -> str:
    """Return why values have no integral over time; '' where they have one.

    Between two values a straight line stands for what was not read. After a run was interrupted, or
    between two recordings, it may be anything.
    """
    steps = np.diff(np.sort(series.times_s))
    if not len(steps):
        return "one value has no integral over time"
    neighbours = np.maximum(np.append(steps[1:], 0.0), np.append(0.0, steps[:-1]))
    longest = int(np.argmax(np.where(neighbours > 0, steps / np.maximum(neighbours, 1e-300), 0.0)))
    if not 0 < LONG * neighbours[longest] < steps[longest]:
        return ""
    return (
        f"nothing was read for {steps[longest]:.3g} s, over {LONG} times as long as before and"
        " after it: what the value was meanwhile is not known"
    )


def _trapezoids(series: Series) -> Array:
    """Return the weight of each value in the integral by the trapezoidal rule, in s, shape (n,)."""
    order = np.argsort(series.times_s, kind="stable")
    halves = np.diff(series.times_s[order]) / 2
    weights = np.zeros(len(order))
    weights[order[:-1]] += halves
    weights[order[1:]] += halves
    return weights


def _integral_scatter(series: Series) -> Scatter | None:
    """Return the scatter of the integral from that of each value about the line of its neighbours.

    A change of what is measured is then no scatter (Gasser, Sroka and Jennen-Steinmetz, Biometrika
    73, 1986, 625). The n - 2 deviations of independent values overlap: they tell as much as 18/35
    of their number would apart.
    """
    order = np.argsort(series.times_s, kind="stable")
    times, values = series.times_s[order], series.from_first[order]
    if len(values) < LEAST_FOR_SLOPE:
        return None
    width = times[2:] - times[:-2]
    later = np.divide(times[1:-1] - times[:-2], width, out=np.zeros(len(width)), where=width > 0)
    deviations = values[1:-1] - (1 - later) * values[:-2] - later * values[2:]
    variance = float(np.mean(deviations**2 / (1 + (1 - later) ** 2 + later**2)))
    weights = _trapezoids(series)
    return sqrt(variance * float(weights @ weights)), max(18 / 35 * len(deviations), 1.0)


def _greatest(_: Series, errors: Array) -> float:
    return float(errors.max())


def _no_scatter(_: Series) -> None:
    return None


STATISTICS = {
    "mean": Statistic(
        lambda series: float(series.values.mean()),
        mean_scatter,
        lambda _, errors: float(errors.mean()),
    ),
    "minimum": Statistic(lambda series: float(series.values.min()), _no_scatter, _greatest),
    "maximum": Statistic(lambda series: float(series.values.max()), _no_scatter, _greatest),
    "range": Statistic(lambda series: float(np.ptp(series.values)), _no_scatter, _greatest),
    "rms": Statistic(_rms, _rms_scatter, _greatest),
    "standard_deviation": Statistic(_deviation, _deviation_scatter, _greatest),
    "slope": Statistic(
        lambda series: float(_weights(series) @ series.from_first),
        _slope_scatter,
        lambda series, errors: float(np.abs(_weights(series)) @ errors),
    ),
    "integral": Statistic(
        lambda series: float(_trapezoids(series) @ series.values),
        _integral_scatter,
        lambda series, errors: float(_trapezoids(series) @ errors),
    ),
}
