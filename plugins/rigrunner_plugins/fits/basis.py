"""Chosen powers of x, with an intercept (power 0) or without.

A drive whose peaks are support friction and inertia alone needs no linear term: {1, f²}.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_plugins.fits.linear import fit_powers, refuse_unfit
from rigrunner_plugins.fits.powers import ScaledPowers

if TYPE_CHECKING:
    from rigrunner.api import Points
    from rigrunner_plugins.fits.curve import FittedCurve
    from rigrunner_plugins.fits.settings import BasisSettings


@dataclass(frozen=True)
class BasisFit:
    """Least squares of chosen powers; satisfies `rigrunner.api.analysis.Fit`."""

    settings: BasisSettings

    def __call__(self, points: Points) -> FittedCurve:
        """Return the fitted curve; raise DataError where the points do not allow it."""
        settings = self.settings
        return fit_chosen_powers(points, settings.powers, weighted=settings.weighted)


def fit_chosen_powers(points: Points, powers: tuple[int, ...], *, weighted: bool) -> FittedCurve:
    """Return the least-squares curve of ascending powers of x; DataError as `fit_powers`."""
    refuse_unfit(points, powers)
    basis = ScaledPowers(powers, scale=float(np.abs(points.x).max()))
    return fit_powers(points, basis, weighted=weighted)
