"""Eq. (1) of Wang et al., Machines 2025, 13(11), 976, doi:10.3390/machines13110976."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from rigrunner.api import Points
from rigrunner_plugins.fits.curve import r_squared
from rigrunner_plugins.fits.polynomial import PolynomialFit
from rigrunner_plugins.fits.settings import PolynomialSettings

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_plugins.fits.curve import FittedCurve

TABLE_2_HZ: Final = (1.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0)
TABLE_2_NM: Final = (0.83, 1.21, 1.64, 2.32, 3.01, 3.96, 5.12, 6.91)
PUBLISHED: Final = (0.9173, 0.0247, 0.0041)
"""Tg = 0.0041 f^2 + 0.0247 f + 0.9173 in N·m with f in Hz, for 1 Hz to 35 Hz."""


def published_curve() -> FittedCurve:
    """Return Eq. (1) as printed, rounded, with the covariance of the fit that it came from.

    The paper states no uncertainty; ordinary least squares of its Table 2 gives its coefficients
    to the printed digits, and with them their covariance.
    """
    points = Points(np.array(TABLE_2_HZ), np.array(TABLE_2_NM))
    fit = PolynomialFit(PolynomialSettings(degree=2))(points)
    coefficients = np.array(PUBLISHED)
    residuals = points.y - _value(points.x)

    def value_and_spread(x: Array) -> tuple[Array, Array]:
        return _value(x), fit.value_and_spread(x)[1]

    return replace(
        fit,
        coefficients=coefficients,
        residuals=residuals,
        residual_s=float(np.sqrt(np.sum(residuals**2) / fit.dof)),
        r_squared=r_squared(points.y, residuals),
        value_and_spread=value_and_spread,
    )


def _value(frequency_hz: Array) -> Array:
    powers = frequency_hz[:, None] ** np.arange(len(PUBLISHED))
    value: Array = powers @ np.array(PUBLISHED)
    return value
