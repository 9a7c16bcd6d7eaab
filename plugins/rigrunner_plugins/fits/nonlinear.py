"""Nonlinear least squares: Levenberg and Marquardt's method, refined in extended precision.

MINPACK's `lmder` (Moré, 1978) through scipy finds the minimum; Gauss-Newton steps in extended
precision then add the digits that double precision lacks.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import least_squares

from rigrunner.api import DataError
from rigrunner_plugins.fits.least_squares import solve

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api import Array
    from rigrunner_plugins.fits.least_squares import Extended, Solution

    Model = Callable[[Extended], tuple[Extended, Extended]]
    """Of parameters (p,): the values (n,) and their derivatives (n, p); nan where not defined."""

EVALUATIONS = 5000
TOLERANCE = 1e-15
STEPS = 50
SETTLED = 1e-12
"""Of a parameter or, if larger, of its standard uncertainty: a step that changes nothing more."""
CONVERGED = 1e-4
"""Likewise: how small the last step must be, or the minimum was not found."""
# Of many such residuals the sum of squares is still finite: MINPACK cannot go on from infinity.
_UNDEFINED = 1e100
_HINT = "give start values nearer to the curve, or a model with fewer parameters"


def minimum(model: Model, y: Extended | Array, start: Array) -> tuple[Extended, Solution]:
    """Return parameters (p,) that minimise |y - model|², and the linear problem at them.

    Raises DataError where the model is not defined at its start, where no minimum is found, and as
    `solve` does.
    """
    if not all(np.isfinite(each).all() for each in model(start.astype(np.longdouble))):
        raise DataError("the model is not defined at its start values for every point", hint=_HINT)
    parameters = _near(model, y, start)
    problem = _linearised(model, y, parameters)
    for _ in range(STEPS):
        left = _length(problem, parameters)
        if left <= SETTLED:
            break
        moved = parameters + problem.coefficients
        next_problem = _linearised(model, y, moved)
        if _length(next_problem, moved) >= left:
            break
        parameters, problem = moved, next_problem
    if not _length(problem, parameters) <= CONVERGED:
        raise DataError("the fit does not converge", hint=_HINT)
    return parameters, problem


def _linearised(model: Model, y: Extended | Array, parameters: Extended) -> Solution:
    values, slopes = model(parameters)
    return solve(slopes, y - values)


def _near(model: Model, y: Extended | Array, start: Array) -> Extended:
    """Return the parameters (p,) of the minimum as far as double precision shows it."""

    def residuals(parameters: Array) -> Array:
        values = model(parameters.astype(np.longdouble))[0] - y
        limited = np.nan_to_num(values, nan=_UNDEFINED, posinf=_UNDEFINED, neginf=-_UNDEFINED)
        return np.asarray(np.clip(limited, -_UNDEFINED, _UNDEFINED), np.float64)

    def slopes(parameters: Array) -> Array:
        found = np.nan_to_num(model(parameters.astype(np.longdouble))[1], posinf=0, neginf=0)
        return np.asarray(np.clip(found, -_UNDEFINED, _UNDEFINED), np.float64)

    found = least_squares(
        residuals, start, slopes, method="lm", x_scale="jac", max_nfev=EVALUATIONS,
        ftol=TOLERANCE, xtol=TOLERANCE, gtol=TOLERANCE,
    )  # fmt: skip
    return np.asarray(found.x, np.longdouble)


def _length(step: Solution, parameters: Extended) -> float:
    """Return how far the step of the linear problem would go: see SETTLED."""
    u = np.sqrt(np.sum((step.factor * step.residual_s) ** 2, axis=1))
    scale = np.maximum(np.maximum(np.abs(parameters), u), np.finfo(np.float64).tiny)
    return float(np.max(np.abs(step.coefficients) / scale))
