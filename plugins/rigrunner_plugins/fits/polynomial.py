"""A polynomial of torque over frequency; of degree 2 it is Eq. (1) of Wang et al.

Machines 2025, 13(11), 976, doi:10.3390/machines13110976: Tg = a f^2 + b f + c, ordinary least
squares of the no-load peaks.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import DataError
from rigrunner_plugins.fits.curve import FittedCurve, r_squared
from rigrunner_plugins.fits.least_squares import Extended, Solution, solve

if TYPE_CHECKING:
    from rigrunner.api.data import Array, Points
    from rigrunner_plugins.fits.settings import PolynomialSettings

_SUPERSCRIPTS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Domain:
    """Maps [low, high] onto [-1, 1], where powers are far from dependent."""

    low: float
    high: float

    def powers(self, x: Array, degree: int) -> Extended:
        """Return the powers 0..degree of the mapped x (n,), shape (n, degree + 1)."""
        mapped = (2 * x.astype(np.longdouble) - self.low - self.high) / self._width
        return np.asarray(mapped[:, None] ** np.arange(degree + 1))

    def to_plain(self, degree: int) -> Extended:
        """Return the matrix that turns coefficients on the mapped x into those on x itself.

        Binomial theorem: t = a x + b gives t^k = sum_j C(k, j) a^j b^(k-j) x^j.
        """
        a = 2 / self._width
        b = -(np.longdouble(self.low) + self.high) / self._width
        matrix = np.zeros((degree + 1, degree + 1), np.longdouble)
        for k in range(degree + 1):
            for j in range(k + 1):
                matrix[j, k] = comb(k, j) * a**j * b ** (k - j)
        return matrix

    @property
    def _width(self) -> np.longdouble:
        return np.longdouble(self.high) - self.low


@dataclass(frozen=True)
class PolynomialFit:
    """Least squares of a polynomial; satisfies `rigrunner.api.analysis.Fit`."""

    settings: PolynomialSettings

    def __call__(self, points: Points) -> FittedCurve:
        """Return the fitted curve; raise DataError where the points do not allow it."""
        degree = self.settings.degree
        domain = _domain(points, degree)
        weights = _weights(points) if self.settings.weighted else np.ones(len(points.x))
        design = domain.powers(points.x, degree)
        y: Extended = points.y.astype(np.longdouble) * weights.astype(np.longdouble)
        solution = solve(design * weights[:, None], y)
        return _curve(points, domain, weights, solution)


def _domain(points: Points, degree: int) -> Domain:
    different = len(np.unique(points.x))
    if different < degree + 2:
        raise DataError(
            f"a polynomial of degree {degree} with its uncertainty needs {degree + 2} different "
            f"frequencies; there are {different}"
        )
    return Domain(float(points.x.min()), float(points.x.max()))


def _weights(points: Points) -> Array:
    """Return square roots of weights of mean square 1: the residual keeps the unit of y."""
    if points.u_y is None or not np.all(points.u_y > 0):
        raise DataError(
            "a weighted fit needs the uncertainty of every point", hint="set weighted: no"
        )
    inverse = 1 / points.u_y
    return np.asarray(inverse / np.sqrt(np.mean(inverse**2)))


def _curve(points: Points, domain: Domain, weights: Array, solution: Solution) -> FittedCurve:
    degree = len(solution.coefficients) - 1
    plain = domain.to_plain(degree)
    s = solution.residual_s
    root = (plain @ solution.factor) * s
    mapped = solution.coefficients
    spread = s * solution.factor

    def value_and_spread(x: Array) -> tuple[Array, Array]:
        powers = domain.powers(x, degree)
        return (powers @ mapped).astype(np.float64), powers.astype(np.float64) @ spread

    return FittedCurve(
        formula="T = " + " + ".join(_term(k) for k in range(degree + 1)),
        names=tuple(f"c{k}" for k in range(degree + 1)),
        units=tuple(_unit(points, k) for k in range(degree + 1)),
        coefficients=(plain @ mapped).astype(np.float64),
        covariance=(root @ root.T).astype(np.float64),
        dof=float(solution.dof),
        residuals=(solution.residuals / weights).astype(np.float64),
        residual_s=s,
        r_squared=r_squared(points.y * weights, solution.residuals.astype(np.float64)),
        valid_x=(domain.low, domain.high),
        value_and_spread=value_and_spread,
    )


def _term(k: int) -> str:
    power = "" if k < 2 else str(k).translate(_SUPERSCRIPTS)  # noqa: PLR2004  (f^1 is f)
    return f"c{k}·f{power}" if k else "c0"


def _unit(points: Points, k: int) -> str:
    if k == 0:
        return points.y_unit
    power = "" if k == 1 else str(k).translate(_SUPERSCRIPTS)
    return f"{points.y_unit}/{points.x_unit}{power}"
