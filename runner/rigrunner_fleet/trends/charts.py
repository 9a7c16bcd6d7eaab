"""Control charts of single values: individuals, moving range, and EWMA.

Limits come from a baseline (phase I) and are then applied to later values (phase II).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import DataError
from rigrunner.api.studies import Limits

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

D2 = 2.0 / sqrt(np.pi)
"""Expected range of two standard normal values, 1.128 (Montgomery, appendix VI)."""
D3 = sqrt(2.0 - 4.0 / np.pi)
"""Standard deviation of that range, 0.8525."""
D4 = 1.0 + 3.0 * D3 / D2
"""Upper limit of the moving range over its mean, 3.267 (ASTM E2587)."""
FEWEST = 10
"""Fewest baseline values for limits; 20 to 25 are advised (ASTM E2587)."""


@dataclass(frozen=True)
class Individuals:
    """A chart of individuals and moving ranges: the limits of both."""

    individuals: Limits
    moving_range: Limits


@dataclass(frozen=True)
class Ewma:
    """An EWMA chart: its values, and the limits at each of them, arrays of equal shape (n,)."""

    values: npt.NDArray[np.float64]
    centre: float
    lower: npt.NDArray[np.float64]
    upper: npt.NDArray[np.float64]


def moving_ranges(values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return the ranges of neighbours, shape (n - 1,), in the unit of the values, shape (n,)."""
    return np.abs(np.diff(np.asarray(values, dtype=np.float64)))


def individuals(baseline: Sequence[float]) -> Individuals:
    """Return the limits of individuals and moving ranges from a baseline, shape (n,).

    The standard deviation is the mean moving range over 1.128 (NIST/SEMATECH e-Handbook 6.3.2.2).
    Raises DataError for too few values and for values that are all equal.
    """
    values = _checked(baseline)
    mean_range = float(moving_ranges(values).mean())
    if mean_range == 0.0:
        raise DataError("the values of the baseline are all the same: limits would have no width")
    centre, sigma = float(values.mean()), mean_range / D2
    return Individuals(
        Limits(centre, sigma, centre - 3.0 * sigma, centre + 3.0 * sigma),
        Limits(mean_range, sigma * D3, 0.0, D4 * mean_range),
    )


def ewma(values: Sequence[float], centre: float, sigma: float, *, weight: float) -> Ewma:
    """Return an EWMA chart of values, shape (n,), about a centre.

    Limits widen with each value towards their asymptote (Montgomery 9.2; NIST/SEMATECH e-Handbook
    6.3.2.4 prints the asymptote). Raises DataError for a weight that is not within 0 to 1.
    """
    if not 0.0 < weight <= 1.0:
        raise DataError(f"the weight of an EWMA is above 0 and at most 1, not {weight:g}")
    smoothed, last = [], centre
    for value in np.asarray(values, dtype=np.float64):
        last = weight * float(value) + (1.0 - weight) * last
        smoothed.append(last)
    number = np.arange(1, len(smoothed) + 1)
    spread = weight / (2.0 - weight) * (1.0 - (1.0 - weight) ** (2 * number))
    half = 3.0 * sigma * np.sqrt(spread)
    return Ewma(np.array(smoothed), centre, centre - half, centre + half)


def lag_one(values: Sequence[float]) -> float:
    """Return the autocorrelation of neighbours, shape (n,) of values, from -1 to 1.

    Beyond 2/sqrt(n) the limits of a chart of individuals do not hold (e-Handbook 6.4.4.3).
    """
    deviations = np.asarray(values, dtype=np.float64) - np.mean(values)
    total = float(deviations @ deviations)
    return float(deviations[1:] @ deviations[:-1]) / total if total > 0.0 else 0.0


def _checked(baseline: Sequence[float]) -> npt.NDArray[np.float64]:
    values = np.asarray(baseline, dtype=np.float64)
    if values.size < FEWEST:
        raise DataError(
            f"a baseline of {values.size} values is too short for limits",
            hint=f"give at least {FEWEST}; 20 to 25 are advised",
        )
    if not np.isfinite(values).all():
        raise DataError("a value of the baseline is not a finite number")
    return values
