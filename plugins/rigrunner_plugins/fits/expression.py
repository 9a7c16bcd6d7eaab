"""A curve of the user's own: least squares of a formula with parameters, of one or more variables.

The formula may depend on its parameters in any way; where it is linear in them, so is the fit, and
any start values serve. Covariance and uncertainty of the curve come from the model linearised at
the minimum, as those that NIST certifies for its nonlinear data sets do.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner.signal.expression.evaluation import evaluated
from rigrunner_plugins.fits.curve import FittedCurve, r_squared, refuse_outside
from rigrunner_plugins.fits.nonlinear import minimum
from rigrunner_plugins.fits.points import refuse_incoherent_units, refuse_not_finite, root_weights
from rigrunner_plugins.fits.requirements import least_points

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api import Array, Points
    from rigrunner.signal.expression.syntax import Expression
    from rigrunner_plugins.fits.least_squares import Extended
    from rigrunner_plugins.fits.settings import ExpressionSettings


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

    def _evaluated(self, x: Array) -> tuple[Array, Array]:
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
        self._refuse_few(columns)
        roots = root_weights(points, weighted=self.settings.weighted)

        def weighted(parameters: Extended) -> tuple[Extended, Extended]:
            value, slopes = model.at(columns, parameters)
            return value * roots, slopes * roots[:, None]

        start = np.array([each.value for each in self.settings.start.values()])
        parameters, problem = minimum(weighted, points.y * roots, start)
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
            units=tuple(each.unit for each in self.settings.start.values()),
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
            given = ", ".join(points.regressors) or "one"
            raise DataError(f"the model is over {', '.join(over)}; the points have {given}")
        return points.regressors

    def _refuse_few(self, columns: Array) -> None:
        different, needed = len(np.unique(columns, axis=0)), least_points(len(self.settings.start))
        if different < needed:
            raise DataError(
                f"{len(self.settings.start)} parameters with their uncertainty need {needed} "
                f"different points, got {different}"
            )


@dataclass(frozen=True)
class _Model:
    expression: Expression
    parameters: tuple[str, ...]
    over: tuple[str, ...]

    def at(self, columns: Array, parameters: Extended) -> tuple[Extended, Extended]:
        """Return the values (m,) over columns (m, k), and the slopes (m, p) by each parameter."""
        given = dict(zip(self.over, columns.T.astype(np.longdouble), strict=True))
        values = given | dict(zip(self.parameters, parameters, strict=True))
        value, slopes = evaluated(self.expression, values, self.parameters)
        shape = columns.shape[:1]
        by = [np.broadcast_to(slopes[name], shape) for name in self.parameters]
        return np.broadcast_to(np.asarray(value, np.longdouble), shape), np.column_stack(by)
