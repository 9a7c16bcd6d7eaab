"""A monotone cubic through the points: no model, so what lies between them is not smoothed.

Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5(2), 1984. For a rig whose peaks follow no formula,
such as one with a resonance inside the sweep. The curve's uncertainty is that of the points, u(y),
carried through point by point (GUM, 5.1.3, note 2); how far the rig departs from the curve between
two points is not in it.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import PchipInterpolator

from rigrunner.api import DataError
from rigrunner_plugins.fits.curve import RANGE_TOLERANCE, FittedCurve
from rigrunner_plugins.fits.points import refuse_not_finite, refuse_several
from rigrunner_plugins.fits.requirements import LEAST_OF_PCHIP

if TYPE_CHECKING:
    from rigrunner.api import Array, Points

_SHARE = 0.01
"""Of the range: x that differ by more are two, also where their zero is arbitrary, as in K."""


def interpolate(points: Points) -> FittedCurve:
    """Return the curve through the points; satisfies `rigrunner.api.analysis.Fit`.

    Its coefficients are the values at the points. Raises DataError for fewer than three points,
    for two at one frequency, and where u(y) is not known.
    """
    points = _sorted(points)
    u_y = points.u_y
    if u_y is None or not (np.isfinite(u_y).all() and np.all(u_y >= 0)):
        raise DataError(
            "an interpolation needs the uncertainty of every point",
            hint="record each point, whose samples show their scatter; of single readings choose a"
            " fit that averages",
        )

    if points.u_x is not None:
        slope = PchipInterpolator(points.x, points.y).derivative()(points.x)
        u_y = np.hypot(u_y, slope * points.u_x)

    def value_and_spread(x: Array) -> tuple[Array, Array]:
        y, step = points.y[:, None], np.diag(u_y)
        at_x = PchipInterpolator(points.x, np.hstack([y, y + step, y - step]))(x)
        value, up, down = np.split(at_x, [1, 1 + len(u_y)], axis=1)
        return value[:, 0], (up - down) / 2

    return FittedCurve(
        formula=f"{points.y_name} = monotone cubic (PCHIP) through the points",
        names=tuple(f"{points.y_name}({x:.4g} {points.x_unit})" for x in points.x),
        units=(points.y_unit,) * len(points.x),
        coefficients=points.y,
        covariance=np.diag(u_y**2),
        dof=inf if points.dof_y is None else float(points.dof_y.min()),
        residuals=np.zeros_like(points.y),
        residual_s=nan,
        r_squared=nan,
        valid_x=(float(points.x[0]), float(points.x[-1])),
        root_weights=np.ones_like(points.y),
        value_and_spread=value_and_spread,
    )


def _sorted(points: Points) -> Points:
    refuse_several(points)
    if len(points.x) < LEAST_OF_PCHIP:
        raise DataError(f"an interpolation needs {LEAST_OF_PCHIP} points, got {len(points.x)}")
    refuse_not_finite(points)
    order = np.argsort(points.x)
    x = points.x[order]
    same = np.minimum(RANGE_TOLERANCE * np.abs(x[:-1]), _SHARE * (x[-1] - x[0]))
    close = np.flatnonzero(np.diff(x) <= same)
    if close.size:
        first, second = x[close[0]], x[close[0] + 1]
        raise DataError(
            f"two points at the same {points.x_name}, {first:.6g} and {second:.6g} {points.x_unit}",
            hint="an interpolation goes through every point; choose a fit that averages",
        )
    u_y, u_x = (None if values is None else values[order] for values in (points.u_y, points.u_x))
    return replace(points, x=x, y=points.y[order], u_y=u_y, u_x=u_x)
