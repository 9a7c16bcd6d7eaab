"""Least-squares curves of powers of x: a polynomial, chosen powers, or the best of some sets."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import log, nan
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner.api.analysis import Candidate
from rigrunner_plugins.fits.curve import FittedCurve, r_squared
from rigrunner_plugins.fits.least_squares import solve
from rigrunner_plugins.fits.points import (
    count_different,
    refuse_not_finite,
    refuse_several,
    root_weights,
)
from rigrunner_plugins.fits.powers import MappedPowers, ScaledPowers, formula, unit
from rigrunner_plugins.fits.requirements import least_points, least_points_of_aicc

if TYPE_CHECKING:
    from rigrunner.api import Array, Points
    from rigrunner_plugins.fits.powers import Powers
    from rigrunner_plugins.fits.settings import AiccSettings, BasisSettings, PolynomialSettings


@dataclass(frozen=True)
class PolynomialFit:
    """Least squares of a polynomial; satisfies `rigrunner.api.analysis.Fit`.

    Of degree 2 and torque over frequency it is Eq. (1) of Wang et al., Machines 2025, 13(11), 976,
    doi:10.3390/machines13110976: Tg = a f^2 + b f + c, ordinary least squares of the no-load peaks.
    """

    settings: PolynomialSettings

    def __call__(self, points: Points) -> FittedCurve:
        """Return the fitted curve; raise DataError where the points do not allow it."""
        degree = self.settings.degree
        _refuse_unfit(points, tuple(range(degree + 1)))
        basis = MappedPowers(degree, float(points.x.min()), float(points.x.max()))
        return _fit(points, basis, weighted=self.settings.weighted)


@dataclass(frozen=True)
class BasisFit:
    """Least squares of chosen powers; satisfies `rigrunner.api.analysis.Fit`.

    With an intercept (power 0) or without. A drive whose peaks are support friction and inertia
    alone needs no linear term: {1, f²}.
    """

    settings: BasisSettings

    def __call__(self, points: Points) -> FittedCurve:
        """Return the fitted curve; raise DataError where the points do not allow it."""
        return _fit_chosen(points, self.settings.powers, weighted=self.settings.weighted)


@dataclass(frozen=True, eq=False)
class ChosenCurve(FittedCurve):
    """A curve with those it was chosen from; satisfies `rigrunner.api.analysis.Chosen`."""

    criterion: str
    candidates: tuple[Candidate, ...]


@dataclass(frozen=True)
class AiccFit:
    """The best of some sets of powers; satisfies `rigrunner.api.analysis.Fit`.

    By the corrected Akaike information criterion: Hurvich and Tsai, Biometrika 76(2), 1989; for
    least squares (Burnham and Anderson, Model Selection and Multimodel Inference, 2.4):
    AICc = n ln(RSS/n) + 2 K + 2 K (K + 1)/(n - K - 1), where K counts the coefficients and the
    variance. Only differences between candidates mean something. The uncertainty of the chosen
    curve is what it would be had it been chosen beforehand.
    """

    settings: AiccSettings

    def __call__(self, points: Points) -> ChosenCurve:
        """Return the best curve; raise DataError where the points allow no candidate."""
        trials = [self._trial(points, powers) for powers in self.settings.candidates]
        curves = [(candidate.score, curve) for candidate, curve in trials if curve is not None]
        if not curves:
            raise DataError(f"no candidate can be fitted: {trials[0][0].problem}")
        best = min(curves, key=lambda pair: pair[0])[1]
        candidates = tuple(replace(candidate, chosen=curve is best) for candidate, curve in trials)
        values = {field.name: getattr(best, field.name) for field in fields(best)}
        return ChosenCurve(**values, criterion="AICc", candidates=candidates)

    def _trial(
        self, points: Points, powers: tuple[int, ...]
    ) -> tuple[Candidate, FittedCurve | None]:
        name, count = formula(powers, points), len(powers)
        try:
            curve = _fit_chosen(points, powers, weighted=self.settings.weighted)
            score = aicc(curve, float(np.abs(points.y).max()))
        except DataError as error:
            return Candidate(name, count, nan, nan, problem=str(error)), None
        return Candidate(name, count, score, curve.residual_s), curve


def aicc(curve: FittedCurve, largest_y: float) -> float:
    """Return the criterion of a least-squares curve; DataError for n <= p + 2 points.

    RSS is no less than what rounding leaves of values as large as `largest_y`: of candidates that
    are exact but for rounding, the simplest is best.
    """
    n, k = len(curve.residuals), len(curve.names) + 1
    needed = least_points_of_aicc(k - 1)
    if n < needed:
        raise DataError(f"AICc of {k - 1} coefficients needs {needed} points, got {n}")
    rounding = n * (np.finfo(np.float64).eps * largest_y) ** 2
    rss = max(curve.residual_s**2 * curve.dof, rounding, np.finfo(np.float64).tiny)
    return n * log(rss / n) + 2 * k + 2 * k * (k + 1) / (n - k - 1)


def _fit_chosen(points: Points, powers: tuple[int, ...], *, weighted: bool) -> FittedCurve:
    _refuse_unfit(points, powers)
    basis = ScaledPowers(powers, scale=float(np.abs(points.x).max()))
    return _fit(points, basis, weighted=weighted)


def _refuse_unfit(points: Points, powers: tuple[int, ...]) -> None:
    """Raise DataError for what is not a number, and for no more different x than coefficients."""
    refuse_several(points)
    refuse_not_finite(points)
    count, needed = count_different(points.x), least_points(len(powers))
    if count < needed:
        raise DataError(
            f"{formula(powers, points)} with its uncertainty needs {needed} different values of "
            f"{points.x_name}, got {count}"
        )


def _fit(points: Points, basis: Powers, *, weighted: bool) -> FittedCurve:
    """Return the least-squares curve; DataError for points that do not give it, or no u(y).

    Coefficients and covariance are those of the plain powers of x; the curve itself and its
    uncertainty are computed from the scaled ones, where nothing cancels.
    """
    roots = root_weights(points, weighted=weighted)
    solution = solve(basis.columns(points.x) * roots[:, None], points.y * roots)
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
