"""Checks of the points of a fit, and their weights."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError, unit
from rigrunner.api.units import is_coherent

if TYPE_CHECKING:
    from rigrunner.api import Array, Points


CLOSE = 1e-3
"""Of the range of x: repetitions of a set-point scatter by less, and are no different places."""
LEAST_DOF = 9
"""Of the scatter that a weight is from; U held 91 % to 95 % then."""


def refuse_not_finite(points: Points) -> None:
    """Raise DataError where an x or a y is nan or infinite."""
    if not (np.isfinite(points.x).all() and np.isfinite(points.y).all()):
        raise DataError("a point of the fit is not a finite number")


def count_different(x: Array) -> int:
    """Return how many x (n,) are farther from each other than a thousandth of their range."""
    ascending = np.sort(x)
    count, last = 0, -np.inf
    for value in ascending:
        if value - last > CLOSE * (ascending[-1] - ascending[0]):
            count, last = count + 1, value
    return count


def refuse_several(points: Points) -> None:
    """Raise DataError where there are several regressors."""
    if points.regressors:
        raise DataError(
            f"a fit of one regressor is given {len(points.regressors)}: "
            f"{', '.join(points.regressors)}",
            hint="use the fit expression",
        )


def refuse_other_units(points: Points) -> None:
    """Raise DataError unless y is in N·m over Hz, or numbers without a unit."""
    if (points.x_unit, points.y_unit) not in {("Hz", "N·m"), ("", "")}:
        raise DataError(f"the fit takes N·m over Hz, not {points.y_unit} over {points.x_unit}")


def refuse_incoherent_units(points: Points) -> None:
    """Raise DataError unless x and y are in SI units, or numbers without a unit."""
    for name in (points.x_unit, points.y_unit):
        if name and not is_coherent(unit(name.strip("()"))):
            raise DataError(f"the fit takes values in SI units, not in {name}")


def root_weights(points: Points, *, weighted: bool) -> Array:
    """Return the square roots (n,) of weights of mean 1: ones, or proportional to 1/u(y).

    So the residual standard deviation keeps the unit of y, and u(y) decides how much a point
    counts against the others, but not how uncertain the curve is: that is for the scatter about
    it. Raises DataError where weights are asked for and a u(y) is unknown, zero or infinite, or of
    few readings: of 20 points with 3 readings each, U of a slope held 70 %.
    """
    if not weighted:
        return np.ones(len(points.x))
    if points.u_y is None or not np.all((points.u_y > 0) & np.isfinite(points.u_y)):
        raise DataError(
            "a weighted fit needs the uncertainty of every point", hint="set weighted: no"
        )
    if points.dof_y is not None and points.dof_y.min() < LEAST_DOF:
        raise DataError(
            f"the weight of a point is from {points.dof_y.min() + 1:.3g} readings, and needs"
            f" {LEAST_DOF + 1}",
            hint="take more readings at each point, or set weighted: no",
        )
    inverse = 1 / points.u_y
    return np.asarray(inverse / np.sqrt(np.mean(inverse**2)))
