"""The uncertainty of a mean of samples in a row, which know much of each other.

Of a stationary series the variance of the mean of n values is

    u^2 = s^2/n [1 + 2 sum (1 - k/n) r(k)],   k = 1 ... cut-off,

with r(k) the autocorrelation at lag k, summed until it cannot be distinguished from chance (Zhang,
Metrologia 43, 2006, S276, equations 6 to 10). The bracket is n over the number of independent
values that tell as much.
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rigrunner.api.data import Array

LEAST = 8
"""Fewest values from which a correlation is estimated."""
MOST = 1 << 16
"""Values that are correlated; of more, means of neighbours are, which have the same mean."""
FEWEST = 2.0
"""Independent values that any series counts for at least: of one there is no scatter."""
_CHANCE = 1.96
"""Standard deviations within which an autocorrelation counts as none (95 %)."""


def mean_error(values: Array) -> tuple[float, float]:
    """Return the standard uncertainty of the mean of successive values (n,), and its dof.

    Type A (GUM 4.2); n must be 2 at least. The degrees of freedom are those of the effective
    number of independent values.
    """
    number = effective_number(values)
    n = len(values)
    # Correlated values scatter less: on average s^2 is sigma^2 (n - n/number)/(n - 1).
    variance = float(values.var(ddof=1)) * (n - 1) / (n - n / number) if number > 1 else 0.0
    return sqrt(variance / number), number - 1


def scatter_of_mean(values: Array) -> tuple[float, float]:
    """Return what `mean_error` does; an uncertainty of 0 for a single value, and for equal ones."""
    return mean_error(values - values[0]) if np.ptp(values) else (0.0, len(values) - 1.0)


def effective_number(values: Array) -> float:
    """Return the effective number of independent values, for the mean of these (n,); n at most."""
    n = len(values)
    size = -(-n // MOST)
    means = values[: n - n % size].reshape(-1, size).mean(axis=1) if size > 1 else values
    spread, of_means = float(values.var()), float(means.var())
    if n < LEAST or spread == 0 or of_means == 0:
        return float(n)
    # First what neighbours within a mean know of each other: means of `size` independent values
    # scatter by 1/size of the variance. Then what the means know of each other.
    inflation = size * of_means / spread * _inflation(means)
    return float(min(max(n / inflation, FEWEST), n))


def _inflation(values: Array) -> float:
    """Return by what the variance of the mean is greater than that of independent values."""
    n = len(values)
    if n < LEAST:
        return 1.0
    deviation = values - values.mean()
    # Padded with zeros, as else the end of the series would be correlated with its beginning.
    padded = 1 << (2 * n - 1).bit_length()
    spectrum = np.fft.rfft(deviation, padded)
    correlation = np.fft.irfft(spectrum * spectrum.conj(), padded)[: n // 4 + 1]
    correlation = correlation / correlation[0]
    # the variance of r(k) beyond the cut-off, of a series that is correlated up to k (Bartlett)
    chance = _CHANCE * np.sqrt((2 * np.cumsum(correlation**2) - 1) / n)
    beyond = np.flatnonzero(np.abs(correlation[1:]) < chance[:-1])
    cut_off = int(beyond[0]) if len(beyond) else len(correlation) - 1
    lags = np.arange(1, cut_off + 1)
    return float(max(1 + 2 * ((1 - lags / n) * correlation[1 : cut_off + 1]).sum(), 1.0))
