"""A least-squares curve of powers of x."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner_plugins.fits.curve import FittedCurve, r_squared
from rigrunner_plugins.fits.least_squares import solve
from rigrunner_plugins.fits.points import (
    different,
    refuse_not_finite,
    refuse_several,
    root_weights,
)
from rigrunner_plugins.fits.powers import formula, unit
from rigrunner_plugins.fits.requirements import least_points

if TYPE_CHECKING:
    from rigrunner.api import Array, Points
    from rigrunner_plugins.fits.least_squares import Solution
    from rigrunner_plugins.fits.powers import Powers


def refuse_unfit(points: Points, powers: tuple[int, ...]) -> None:
    """Raise DataError for what is not a number, and for no more different x than coefficients."""
    refuse_several(points)
    refuse_not_finite(points)
    found, needed = different(points.x), least_points(len(powers))
    if found < needed:
        raise DataError(
            f"{formula(powers, points)} with its uncertainty needs {needed} different values of "
            f"{points.x_name}, got {found}"
        )


def fit_powers(points: Points, basis: Powers, *, weighted: bool) -> FittedCurve:
    """Return the least-squares curve; DataError for points that do not give it, or no u(y).

    Coefficients and covariance are those of the plain powers of x; the curve itself and its
    uncertainty are computed from the scaled ones, where nothing cancels.
    """
    roots = root_weights(points, weighted=weighted)
    solution = solve(basis.columns(points.x) * roots[:, None], points.y * roots)
    return _curve(points, basis, roots, solution)


def _curve(points: Points, basis: Powers, roots: Array, solution: Solution) -> FittedCurve:
    plain = basis.to_plain()
    residuals = (solution.residuals / roots).astype(np.float64)
    spread = solution.factor * solution.residual_s
    covariance_root = plain @ spread

    def value_and_spread(x: Array) -> tuple[Array, Array]:
        columns = basis.columns(x)
        value, rows = columns @ solution.coefficients, columns @ spread
        return value.astype(np.float64), rows.astype(np.float64)

    return FittedCurve(
        formula=formula(basis.powers, points),
        names=tuple(f"c{k}" for k in basis.powers),
        units=tuple(unit(points.y_unit, points.x_unit, k) for k in basis.powers),
        coefficients=(plain @ solution.coefficients).astype(np.float64),
        covariance=(covariance_root @ covariance_root.T).astype(np.float64),
        dof=float(solution.dof),
        residuals=residuals,
        residual_s=solution.residual_s,
        r_squared=r_squared(points.y, residuals, roots=roots, about_mean=0 in basis.powers),
        valid_x=(float(points.x.min()), float(points.x.max())),
        root_weights=roots,
        value_and_spread=value_and_spread,
    )
