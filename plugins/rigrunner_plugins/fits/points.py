"""What fits ask of their points: that they are numbers, and how much each counts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import DataError

if TYPE_CHECKING:
    from rigrunner.api.data import Array, Points


def refuse_not_finite(points: Points) -> None:
    """Raise DataError where an x or a y is nan or infinite."""
    if not (np.isfinite(points.x).all() and np.isfinite(points.y).all()):
        raise DataError("a point of the fit is not a finite number")


def root_weights(points: Points, *, weighted: bool) -> Array:
    """Return the square roots (n,) of weights of mean 1: ones, or proportional to 1/u(y).

    So the residual standard deviation keeps the unit of y, and u(y) decides how much a point
    counts against the others, but not how uncertain the curve is: that is for the scatter about
    it. Raises DataError where weights are asked for and a u(y) is unknown, zero or infinite.
    """
    if not weighted:
        return np.ones(len(points.x))
    if points.u_y is None or not np.all((points.u_y > 0) & np.isfinite(points.u_y)):
        raise DataError(
            "a weighted fit needs the uncertainty of every point", hint="set weighted: no"
        )
    inverse = 1 / points.u_y
    return np.asarray(inverse / np.sqrt(np.mean(inverse**2)))
