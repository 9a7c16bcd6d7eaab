"""A curve of the user's own: least squares of a formula with parameters, of one or more variables.

The formula may depend on its parameters in any way; where it is linear in them, so is the fit, and
any start values serve. Covariance and uncertainty of the curve come from the model linearised at
the minimum, as those that NIST certifies for its nonlinear data sets do.

The minimum is found by Levenberg and Marquardt's method: MINPACK's `lmder` (Moré, 1978) through
scipy. Gauss-Newton steps in extended precision then add the digits that double precision lacks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import least_squares

from rigrunner.api import DataError
from rigrunner.signal.expression.evaluation import evaluated
from rigrunner_plugins.fits.curve import FittedCurve, r_squared, refuse_outside
from rigrunner_plugins.fits.least_squares import solve
from rigrunner_plugins.fits.points import refuse_incoherent_units, refuse_not_finite, root_weights
from rigrunner_plugins.fits.requirements import least_points

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rigrunner.api import Array, Points
    from rigrunner.signal.expression.syntax import Expression
    from rigrunner_plugins.fits.least_squares import Extended, Solution
    from rigrunner_plugins.fits.settings import ExpressionSettings

    Model = Callable[[Extended], tuple[Extended, Extended]]
    """Of parameters (p,): the values (n,) and their derivatives (n, p); nan where not defined."""

EVALUATIONS = 5000
"""Those of NIST's data sets take up to 760: a search that takes so many finds nothing any more."""
TOLERANCE = 1e-15
"""Relative, for all criteria of MINPACK: less than the last digit, so it goes as far as it can."""
STEPS = 50
"""Gauss-Newton steps at most; near the minimum a few are enough."""
SETTLED = 1e-12
"""Of a parameter or, if larger, of its standard uncertainty: a step that changes nothing more."""
CONVERGED = 1e-4
"""Likewise: how small the last step must be, or the minimum was not found."""
# Of many such residuals the sum of squares is still finite: MINPACK cannot go on from infinity.
_UNDEFINED = 1e100
_HINT = "give start values nearer to the curve, or a model with fewer parameters"


@dataclass(frozen=True, eq=False)
class FittedExpression(FittedCurve):
    """A curve over one variable; of k variables `predict` takes x of shape (m, k).

    `valid_x` is the range of the first.
    """

    ranges: Mapping[str, tuple[float, float]]
    """Of each variable, the range of the points."""

    def extrapolate(self, x: Array) -> tuple[Array, Array]:
        """Return the curve at any x and its standard uncertainty, outside the ranges too."""
        return super().extrapolate(np.asarray(x, np.float64).reshape(-1, len(self.ranges)))

    def _evaluate(self, x: Array) -> tuple[Array, Array]:
        columns = np.asarray(x, np.float64).reshape(-1, len(self.ranges))
        for (name, valid), values in zip(self.ranges.items(), columns.T, strict=True):
            refuse_outside(values, valid, name if len(self.ranges) > 1 else "")
        return self.value_and_spread(columns)


@dataclass(frozen=True)
class ExpressionFit:
    """Least squares of a formula; satisfies `rigrunner.api.analysis.Fit`."""

    settings: ExpressionSettings

    def __call__(self, points: Points) -> FittedExpression:
        """Return the fitted curve; raise DataError where the points do not allow it."""
        refuse_incoherent_units(points)
        refuse_not_finite(points)
        model = _Model(self.settings.expression, tuple(self.settings.start), self._over(points))
        columns = points.x.reshape(len(points.y), len(model.over))
        different, needed = len(np.unique(columns, axis=0)), least_points(len(model.parameters))
        if different < needed:
            raise DataError(
                f"{len(model.parameters)} parameters with their uncertainty need {needed} "
                f"different points, got {different}"
            )
        roots = root_weights(points, weighted=self.settings.weighted)

        def weighted(parameters: Extended) -> tuple[Extended, Extended]:
            value, slopes = model.at(columns, parameters)
            return value * roots, slopes * roots[:, None]

        start = np.array([parameter.value for parameter in self.settings.start.values()])
        parameters, problem = _minimum(weighted, points.y * roots, start)
        spread = problem.factor * problem.residual_s
        residuals = (points.y - model.at(columns, parameters)[0]).astype(np.float64)

        def value_and_spread(x: Array) -> tuple[Array, Array]:
            value, slopes = model.at(x, parameters)
            return value.astype(np.float64), (slopes @ spread).astype(np.float64)

        ranges = {
            name: (float(values.min()), float(values.max()))
            for name, values in zip(model.over, columns.T, strict=True)
        }
        return FittedExpression(
            formula=f"{points.y_name} = {self.settings.model}",
            names=model.parameters,
            units=tuple(parameter.unit for parameter in self.settings.start.values()),
            coefficients=parameters.astype(np.float64),
            covariance=(spread @ spread.T).astype(np.float64),
            dof=float(problem.dof),
            residuals=residuals,
            residual_s=problem.residual_s,
            r_squared=r_squared(points.y, residuals, roots=roots),
            valid_x=next(iter(ranges.values())),
            root_weights=roots,
            value_and_spread=value_and_spread,
            ranges=ranges,
        )

    def _over(self, points: Points) -> tuple[str, ...]:
        """Return the model's variables in the order of the columns of x."""
        over = self.settings.over
        if len(over) == 1 and not points.regressors:
            return over
        if sorted(over) != sorted(points.regressors):
            regressors = ", ".join(points.regressors) or "one"
            raise DataError(f"the model is over {', '.join(over)}; the points have {regressors}")
        return points.regressors


@dataclass(frozen=True)
class _Model:
    expression: Expression
    parameters: tuple[str, ...]
    over: tuple[str, ...]

    def at(self, columns: Array, parameters: Extended) -> tuple[Extended, Extended]:
        """Return the values (m,) over columns (m, k), and the slopes (m, p) by each parameter."""
        variables = dict(zip(self.over, columns.T.astype(np.longdouble), strict=True))
        values = variables | dict(zip(self.parameters, parameters, strict=True))
        value, slopes = evaluated(self.expression, values, self.parameters)
        shape = columns.shape[:1]
        by = [np.broadcast_to(slopes[name], shape) for name in self.parameters]
        return np.broadcast_to(np.asarray(value, np.longdouble), shape), np.column_stack(by)


def _minimum(model: Model, y: Extended | Array, start: Array) -> tuple[Extended, Solution]:
    """Return parameters (p,) that minimise |y - model|², and the linear problem at them.

    Raises DataError where the model is not defined at its start, where no minimum is found, and as
    `solve` does.
    """
    if not all(np.isfinite(array).all() for array in model(start.astype(np.longdouble))):
        raise DataError("the model is not defined at its start values for every point", hint=_HINT)
    parameters = _near(model, y, start)
    problem = _linearise(model, y, parameters)
    for _ in range(STEPS):
        remaining = _length(problem, parameters)
        if remaining <= SETTLED:
            break
        moved = parameters + problem.coefficients
        next_problem = _linearise(model, y, moved)
        if _length(next_problem, moved) >= remaining:
            break
        parameters, problem = moved, next_problem
    if not _length(problem, parameters) <= CONVERGED:
        raise DataError("the fit does not converge", hint=_HINT)
    return parameters, problem


def _linearise(model: Model, y: Extended | Array, parameters: Extended) -> Solution:
    values, slopes = model(parameters)
    return solve(slopes, y - values)


def _near(model: Model, y: Extended | Array, start: Array) -> Extended:
    """Return the parameters (p,) of the minimum as far as double precision shows it."""

    def residuals(parameters: Array) -> Array:
        values = model(parameters.astype(np.longdouble))[0] - y
        limited = np.nan_to_num(values, nan=_UNDEFINED, posinf=_UNDEFINED, neginf=-_UNDEFINED)
        return np.asarray(np.clip(limited, -_UNDEFINED, _UNDEFINED), np.float64)

    def slopes(parameters: Array) -> Array:
        derivatives = np.nan_to_num(model(parameters.astype(np.longdouble))[1], posinf=0, neginf=0)
        return np.asarray(np.clip(derivatives, -_UNDEFINED, _UNDEFINED), np.float64)

    minimum = least_squares(
        residuals, start, slopes, method="lm", x_scale="jac", max_nfev=EVALUATIONS,
        ftol=TOLERANCE, xtol=TOLERANCE, gtol=TOLERANCE,
    )  # fmt: skip
    return np.asarray(minimum.x, np.longdouble)


def _length(step: Solution, parameters: Extended) -> float:
    """Return how far the step of the linear problem would go: see SETTLED."""
    u = np.sqrt(np.sum((step.factor * step.residual_s) ** 2, axis=1))
    scale = np.maximum(np.maximum(np.abs(parameters), u), np.finfo(np.float64).tiny)
    return float(np.max(np.abs(step.coefficients) / scale))
