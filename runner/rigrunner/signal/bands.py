"""How well a fitted curve is known, and where one more point would fall."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.uncertainty import coverage_factor

if TYPE_CHECKING:
    from rigrunner.api.analysis import Curve
    from rigrunner.api.data import Array


@dataclass(frozen=True, eq=False)
class Bands:
    """A curve with half-widths about it, in the unit of y; each of shape (n,)."""

    value: Array
    confidence: Array
    """Of the curve itself."""
    prediction: Array
    """Of one more point measured like the others, of average weight; nan if unknown."""


def bands(curve: Curve, x: Array, p: float = 0.95) -> Bands:
    """Return the pointwise bands of probability p at x of shape (n,).

    k u and k sqrt(u^2 + s^2), with the curve's u, the residual's s, and k from Student's t (Draper
    and Smith, Applied Regression Analysis, 3.1). Raises DataError outside the curve's range.
    """
    value, u = curve.predict(x)
    k = coverage_factor(curve.dof, p)
    return Bands(value, k * u, k * np.hypot(u, curve.residual_s))
