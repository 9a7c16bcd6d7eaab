"""The best of some candidate sets of powers, by the corrected Akaike information criterion.

Hurvich and Tsai, Biometrika 76(2), 1989; for least squares (Burnham and Anderson, Model Selection
and Multimodel Inference, 2.4): AICc = n ln(RSS/n) + 2 K + 2 K (K + 1)/(n - K - 1), where K counts
the coefficients and the variance. Only differences between candidates mean something. The
uncertainty of the chosen curve is what it would be had it been chosen beforehand.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import log, nan
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner.api.analysis import Candidate
from rigrunner_plugins.fits.basis import fit_chosen_powers
from rigrunner_plugins.fits.curve import FittedCurve
from rigrunner_plugins.fits.powers import formula
from rigrunner_plugins.fits.requirements import least_points_of_aicc

if TYPE_CHECKING:
    from rigrunner.api import Points
    from rigrunner_plugins.fits.settings import AiccSettings


@dataclass(frozen=True, eq=False)
class ChosenCurve(FittedCurve):
    """A curve with those it was chosen from; satisfies `rigrunner.api.analysis.Chosen`."""

    criterion: str
    candidates: tuple[Candidate, ...]


@dataclass(frozen=True)
class AiccFit:
    """The candidate of least AICc; satisfies `rigrunner.api.analysis.Fit`."""

    settings: AiccSettings

    def __call__(self, points: Points) -> ChosenCurve:
        """Return the best curve; raise DataError where the points allow no candidate."""
        tried = [self._tried(points, powers) for powers in self.settings.candidates]
        curves = [(candidate.score, curve) for candidate, curve in tried if curve is not None]
        if not curves:
            raise DataError(f"no candidate can be fitted: {tried[0][0].problem}")
        best = min(curves, key=lambda pair: pair[0])[1]
        candidates = tuple(replace(each, chosen=curve is best) for each, curve in tried)
        values = {field.name: getattr(best, field.name) for field in fields(best)}
        return ChosenCurve(**values, criterion="AICc", candidates=candidates)

    def _tried(
        self, points: Points, powers: tuple[int, ...]
    ) -> tuple[Candidate, FittedCurve | None]:
        name, count = formula(powers, points), len(powers)
        try:
            curve = fit_chosen_powers(points, powers, weighted=self.settings.weighted)
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
