"""A polynomial of torque over frequency; of degree 2 it is Eq. (1) of Wang et al.

Machines 2025, 13(11), 976, doi:10.3390/machines13110976: Tg = a f^2 + b f + c, ordinary least
squares of the no-load peaks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner_plugins.fits.linear import fit_powers, refuse_unfit
from rigrunner_plugins.fits.powers import MappedPowers

if TYPE_CHECKING:
    from rigrunner.api import Points
    from rigrunner_plugins.fits.curve import FittedCurve
    from rigrunner_plugins.fits.settings import PolynomialSettings


@dataclass(frozen=True)
class PolynomialFit:
    """Least squares of a polynomial; satisfies `rigrunner.api.analysis.Fit`."""

    settings: PolynomialSettings

    def __call__(self, points: Points) -> FittedCurve:
        """Return the fitted curve; raise DataError where the points do not allow it."""
        degree = self.settings.degree
        refuse_unfit(points, tuple(range(degree + 1)))
        basis = MappedPowers(degree, float(points.x.min()), float(points.x.max()))
        return fit_powers(points, basis, weighted=self.settings.weighted)
