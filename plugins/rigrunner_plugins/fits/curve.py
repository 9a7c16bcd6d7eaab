"""A fitted curve with its covariance, whatever its model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api import Array

RANGE_TOLERANCE = 0.005
"""Relative: a rig's speed scatters by less, and an end of the range is still that set-point."""
_SHARE = 0.05
"""Of the range: farther is outside, where the zero of x is arbitrary, as for a temperature in K."""


@dataclass(frozen=True, eq=False)
class FittedCurve:
    """A curve through n points with p coefficients; satisfies `rigrunner.api.analysis.Curve`."""

    formula: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    coefficients: Array
    covariance: Array
    dof: float
    residuals: Array
    residual_s: float
    r_squared: float
    valid_x: tuple[float, float]
    root_weights: Array
    """Square roots (n,) of the points' weights, of mean 1."""
    value_and_spread: Callable[[Array], tuple[Array, Array]]
    """At x of shape (m,): the curve (m,), and rows (m, p) whose norm is its standard uncertainty.

    The rows are the curve's gradient times a square root of the covariance: so no uncertainty is
    lost, nor negative, where coefficients are nearly dependent.
    """

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Return the curve at x (m,) and its standard uncertainty; DataError outside `valid_x`."""
        value, spread = self._evaluate(x)
        return value, np.linalg.norm(spread, axis=1)

    def spread(self, x: Array) -> Array:
        """Return the uncertainty at x (m,) in independent directions, as `Spreading` has it."""
        return self._evaluate(x)[1]

    def extrapolate(self, x: Array) -> tuple[Array, Array]:
        """Return the curve at any x (m,) and its standard uncertainty, outside `valid_x` too."""
        value, spread = self.value_and_spread(np.atleast_1d(np.asarray(x, np.float64)))
        return value, np.linalg.norm(spread, axis=1)

    def _evaluate(self, x: Array) -> tuple[Array, Array]:
        x = np.atleast_1d(np.asarray(x, np.float64))
        refuse_outside(x, self.valid_x)
        return self.value_and_spread(x)


def refuse_outside(x: Array, valid: tuple[float, float], name: str = "") -> None:
    """Raise DataError where one of x (m,) is out of range; `name` is its, if there are several."""
    low, high = valid
    # Of several regressors one may be constant but for its scatter.
    most = np.inf if name else _SHARE * (high - low)
    below, above = (min(RANGE_TOLERANCE * abs(end), most) for end in valid)
    inside = (x >= low - below) & (x <= high + above)
    outside = x[~inside]
    if outside.size:
        of = f" of {name}" if name else ""
        raise DataError(
            f"the fit holds from {low:.6g} to {high:.6g}{of}, not at {outside[0]:.6g}",
            hint="a fit is not valid outside its points; measure there",
        )


def r_squared(
    y: Array, residuals: Array, *, roots: Array | None = None, about_mean: bool = True
) -> float:
    """Return 1 - RSS/TSS of y and residuals of shape (n,); nan where y does not vary.

    `roots` are the square roots of the weights. Without an intercept the total is taken about
    zero, as NIST's StRD does.
    """
    weights = np.ones(len(y)) if roots is None else roots**2
    centre = np.average(y, weights=weights) if about_mean else 0.0
    total = float(np.sum(weights * (y - centre) ** 2))
    rounding = len(y) * (np.finfo(np.float64).eps * np.abs(y).max()) ** 2
    if total <= rounding:
        return float("nan")
    return 1 - float(np.sum(weights * residuals**2)) / total
