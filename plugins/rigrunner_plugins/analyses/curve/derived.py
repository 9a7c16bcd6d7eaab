"""Values derived from a fitted curve, with their uncertainty from the scatter about it.

A value is first derived from the points as measured. This fixes choices such as the place of the
greatest deviation. Its function `recompute` then gives the value for other points with the same
choices, and so the effect of an instrument's error.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, isnan, sqrt
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from rigrunner.api import DataError, Spreading, unit
from rigrunner.api.analysis.curves import Extrapolating, Weighted
from rigrunner.api.places import matches
from rigrunner.api.units import from_si
from rigrunner_plugins.analyses.curve.settings import SAME_X

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from rigrunner.api import Array, Curve, Fit, Quantity
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner_plugins.analyses.curve.points import Values
    from rigrunner_plugins.analyses.curve.settings import (
        BothWays,
        Nonlinearity,
        Slope,
        ValueAt,
        XAt,
    )

GRID = 1000
"""Number of grid steps in which a curve is searched for a given y."""
SMALL = 1e-5
"""Step for the slope of another curve at a place, as a share of the range of x."""
NEAR = 0.01
"""The places for the slope of a smooth curve are within this share of the range of x."""
_FIVE = np.linspace(-1, 1, 5)
CERTAIN = 2.0
"""Number of standard uncertainties by which the slope must differ from zero to solve for x."""
LINEAR = 0.05
"""Greatest (k u/slope)² at which a first-order uncertainty is accepted (Fieller's g)."""
EDGE = 1e-9


class OutOfRangeError(Exception):
    """The curve does not give this value; the message says why."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """Points with the curve through them."""

    values: Values
    curve: Curve

    @property
    def ends(self) -> tuple[float, float]:
        """The range of x in the units of the curve."""
        x = self.values.x[:, 0]
        return float(x.min()), float(x.max())

    def at(self, x: Array | float) -> tuple[Array, Array]:
        """Return the curve and its standard uncertainty, extrapolated if needed."""
        x = np.atleast_1d(np.asarray(x, np.float64))
        if isinstance(self.curve, Extrapolating):
            return self.curve.extrapolate(x)
        return self.curve.predict(np.clip(x, *self.curve.valid_x) if x.ndim == 1 else x)

    def y(self, x: float) -> float:
        """Return the curve at one x."""
        return float(self.at(x)[0][0])

    def slope(self, x: float) -> tuple[float, float]:
        """Return the slope at one x and its standard uncertainty."""
        low, high = self.ends
        if isinstance(self.curve, Spreading):
            # By the quartic through five places near x: over the step of a difference quotient the
            # rounding of a large y would hide the effect of an error. Near an end they are inside.
            half = NEAR * (high - low)
            middle = min(max(x, min(low, x) + half), max(high, x) - half)
            places = middle + half * _FIVE
            powers = np.arange(len(_FIVE))
            at = (powers * ((x - middle) / half) ** np.maximum(powers - 1, 0)) / half
            weights = np.linalg.solve(np.vander(_FIVE, increasing=True).T, at)
            y, spread = self.at(places)[0], self.curve.spread(np.clip(places, low, high))
            return float(weights @ (y - y[0])), float(np.linalg.norm(weights @ spread))
        step = SMALL * (high - low)
        # One-sided at the ends, since the curve need not exist beyond its points. The u of two
        # places close together, taken as independent, would grow without limit over so small a
        # step: the mean slope's stands for it.
        value, _ = self.between(max(x - step, min(low, x)), min(x + step, max(high, x)))
        return value, self.between(low, high)[1]

    def between(self, low: float, high: float) -> tuple[float, float]:
        """Return the mean slope between two x and its standard uncertainty."""
        ends, width = np.array([low, high]), high - low
        value, u = self.at(ends)
        spread = u
        if isinstance(self.curve, Spreading) and self.is_inside(ends):
            spread = np.linalg.norm(np.diff(self.curve.spread(ends), axis=0), axis=1)
        return float(value[1] - value[0]) / width, float(np.sqrt(np.sum(spread**2))) / width

    def is_inside(self, x: Array | Sequence[float]) -> bool:
        """Return whether x is within the range of the points, for each place or each regressor."""
        columns = self.values.x if len(self.values.names) > 1 else self.values.x[:, :1]
        low, high = columns.min(axis=0), columns.max(axis=0)
        edge = EDGE * (high - low)
        return bool(np.all((np.asarray(x) >= low - edge) & (np.asarray(x) <= high + edge)))

    @property
    def scale(self) -> Array:
        """The scatter of each y in units of the residual standard deviation, shape (n,)."""
        if isinstance(self.curve, Weighted):
            return 1 / self.curve.root_weights
        return np.ones(len(self.values.y))

    def scatter(self, x: float) -> float:
        """Return the standard deviation of a y at one x: between points, along straight lines."""
        distinct_x, index = np.unique(self.values.x[:, 0], return_inverse=True)
        mean_square = np.bincount(index, self.scale**2) / np.bincount(index)
        return self.curve.residual_s * float(np.interp(x, distinct_x, np.sqrt(mean_square)))

    def span(self) -> float:
        """Return the difference between the highest and lowest y of the curve at the points.

        Raises OutOfRangeError if y does not change, because no share of zero can be stated.
        """
        y = self.at(self.values.x[:, 0])[0]
        span = float(np.ptp(y))
        if span <= EDGE * float(np.abs(y).max()):
            raise OutOfRangeError("the curve does not rise or fall: its span is 0")
        return span


@dataclass(frozen=True, eq=False)
class Derived:
    """A value derived from a curve, in SI units."""

    value: float
    u: float
    """Standard uncertainty, type A."""
    dof: float
    recompute: Callable[[Fitted], float]
    is_difference: bool = False
    """Whether it is a difference of readings of the same instrument at one place."""
    by_requested_y: float = 0.0
    """Its sensitivity to an error of the measured y alone for which x was requested."""
    note: str = ""


def parameter(fitted: Fitted, name: str) -> Derived:
    """Return a coefficient of the fit."""
    names = list(fitted.curve.names)
    if name not in names:
        raise DataError(f"the fit has no parameter '{name}'; it has: {', '.join(names)}")
    place = names.index(name)

    def recompute(other: Fitted) -> float:
        return float(other.curve.coefficients[place])

    u = sqrt(float(fitted.curve.covariance[place, place]))
    return Derived(recompute(fitted), u, fitted.curve.dof, recompute)


def value_at(fitted: Fitted, settings: ValueAt, at: Mapping[str, Quantity]) -> Derived:
    """Return the curve at a place; raise OutOfRangeError outside the points, unless allowed."""
    x = np.array([at[name].si - fitted.values.origin for name in fitted.values.names])
    inside = fitted.is_inside(x)
    place = ", ".join(map(str, at.values()))
    if not inside and not settings.extrapolate:
        hint = "measure there, or say 'extrapolate: yes'"
        raise OutOfRangeError(f"{place} is outside the points, {_range(fitted, at)}: {hint}")
    if not inside and not isinstance(fitted.curve, Extrapolating):
        raise OutOfRangeError(f"{place} is outside the points, and this fit gives nothing there")
    row = x[None, :] if len(x) > 1 else x

    def recompute(other: Fitted) -> float:
        return float(other.at(row)[0][0])

    u = float(fitted.at(row)[1][0])
    note = "" if inside else (
        f"{place} is outside the points, {_range(fitted, at)}: the uncertainty is that of the"
        " coefficients, if the curve holds there"
    )  # fmt: skip
    return Derived(recompute(fitted), u, fitted.curve.dof, recompute, note=note)


def x_at(fitted: Fitted, settings: XAt, index: int, count: int) -> Derived:
    """Return the x at which the curve reaches y; raise OutOfRangeError for no or several solutions.

    First order: u(x)² = (u(curve)² + s²/m) / slope², with m readings of y (Draper and Smith,
    Applied Regression Analysis, 3rd edition, 3.2).
    """
    y = float(fitted.values.requested_y[index])
    if isnan(y):
        condition = ", ".join(f"{name} = {value}" for name, value in settings.where.items())
        raise OutOfRangeError(f"{fitted.values.y_name} was not measured at {condition}")
    grid = np.linspace(*fitted.ends, GRID + 1)
    residuals = fitted.at(grid)[0] - y
    scale = EDGE * max(float(np.ptp(residuals)), 1e-300)
    # A root on a grid step counts once: rounding must not make two changes of sign of it, or
    # none.
    residuals[np.abs(residuals) <= scale] = 0.0
    roots = [float(x) for x in grid[residuals == 0]]
    roots += [
        float(brentq(lambda x: fitted.y(x) - y, grid[i], grid[i + 1]))
        for i in np.flatnonzero(residuals[:-1] * residuals[1:] < 0)
    ]
    shown = f"{from_si(y, _shown(fitted.values.y_unit)):.6g} {_shown(fitted.values.y_unit)}"
    if not roots:
        raise OutOfRangeError(f"the curve takes the value {shown} nowhere within its points")
    if len(roots) > 1:
        raise OutOfRangeError(f"the curve takes the value {shown} at {len(roots)} places")
    (x,) = roots
    slope, u_slope = fitted.slope(x)
    if abs(slope) <= CERTAIN * u_slope:
        raise OutOfRangeError(
            f"the slope of the curve at the value {shown} is not significantly different from zero"
        )
    s = fitted.scatter(x) / sqrt(count) if count else 0.0
    g = (CERTAIN * u_slope / slope) ** 2
    note = f"(2 u/slope)² is {g:.2g}: the interval is only nearly symmetric" if g > LINEAR else ""

    def recompute(other: Fitted) -> float:
        difference = other.values.requested_y[index] - other.y(x)
        return x + fitted.values.origin + float(difference) / slope

    u = hypot(float(fitted.at(x)[1][0]), s) / abs(slope)
    by_y = 1 / slope if count else 0.0
    return Derived(
        recompute(fitted), u, fitted.curve.dof, recompute, by_requested_y=by_y, note=note
    )


def slope(fitted: Fitted, settings: Slope) -> Derived:
    """Return the slope at a place, or the mean slope; raise OutOfRangeError outside the points."""
    if settings.at is None:
        low, high = fitted.ends

        def recompute(other: Fitted) -> float:
            return other.between(low, high)[0]

        return Derived(recompute(fitted), fitted.between(low, high)[1], fitted.curve.dof, recompute)
    at = settings.at
    x = at.si - fitted.values.origin
    if not fitted.is_inside([x]):
        raise OutOfRangeError(f"{at} is outside the points, {_range(fitted, {'': at})}")

    def recompute_at(other: Fitted) -> float:
        return other.slope(x)[0]

    return Derived(recompute_at(fitted), fitted.slope(x)[1], fitted.curve.dof, recompute_at)


def nonlinearity(fitted: Fitted, settings: Nonlinearity) -> Derived:
    """Return the greatest deviation of the mean at each x from the least-squares line."""
    x = fitted.values.x[:, 0]
    clusters = same_x(fitted.values, np.zeros(len(x)))
    if len(clusters) <= 2:  # noqa: PLR2004  (a line goes through two)
        raise DataError(
            f"{settings.name} needs values at three different x; there are {len(clusters)}"
        )

    def deviations(other: Fitted) -> Array:
        x, y = other.values.x[:, 0], other.values.y
        steepness, constant = np.polyfit(x - x.mean(), y, 1)
        return np.asarray(y - constant - steepness * (x - x.mean()))

    measured = deviations(fitted)
    rows = max(clusters, key=lambda cluster: abs(measured[cluster].mean()))
    sign = 1.0 if measured[rows].mean() >= 0 else -1.0
    from_middle = x - x.mean()
    # How much each y enters the mean deviation: the line takes away its constant and its slope.
    weights = -1 / len(x) - from_middle[rows].mean() * from_middle / sum(from_middle**2)
    weights[rows] += 1 / len(rows)
    s, dof = fitted.curve.residual_s, fitted.curve.dof

    def recompute(other: Fitted) -> float:
        deviation = float(deviations(other)[rows].mean())
        return sign * deviation / (other.span() if settings.of_span else 1.0)

    span = fitted.span() if settings.of_span else 1.0
    u = s * float(np.linalg.norm(weights * fitted.scale)) / span
    return Derived(recompute(fitted), u, dof, recompute)


def both_ways(
    fitted: Fitted,
    settings: BothWays,
    places: Sequence[Mapping[str, CoordinateValue]],
    fit: Fit,
    *,
    at_zero: bool,
) -> Derived:
    """Return falling minus rising y at one x: the greatest by magnitude, or that nearest to x = 0.

    Uses residuals, so x may differ slightly between the two directions. Type A is the scatter of
    repeated values, or else the scatter about one curve per direction. With one curve for both
    directions, the hysteresis itself would count as scatter.
    """
    x, ways = fitted.values.x[:, 0], _directions(settings, places)
    clusters = [
        (rows[ways[rows] == 0], rows[ways[rows] == 1])
        for rows in same_x(fitted.values, ways)
        if {0, 1} <= set(ways[rows].tolist())
    ]
    if not clusters:
        rising, falling = settings.ways
        raise DataError(
            f"{settings.name}: at no x was there both {settings.label} = {rising} and {falling}"
        )

    residuals = _residuals(fitted)
    differences = [
        residuals[falling].mean() - residuals[rising].mean() for rising, falling in clusters
    ]
    sizes = [-abs(float(x[r].mean() + fitted.values.origin)) for r, _ in clusters]
    which = int(np.argmax(sizes if at_zero else np.abs(differences)))
    sign = 1.0 if at_zero or differences[which] >= 0 else -1.0
    rising, falling = clusters[which]
    s, dof = _repeatability(fitted, clusters) or _about_each_way(fitted, ways, fit)

    def recompute(other: Fitted) -> float:
        residuals = _residuals(other)
        difference = float(residuals[falling].mean() - residuals[rising].mean())
        return sign * difference / (other.span() if settings.of_span else 1.0)

    shares = [float(np.sum(fitted.scale[rows] ** 2)) / len(rows) ** 2 for rows in (rising, falling)]
    u = s * sqrt(sum(shares)) / (fitted.span() if settings.of_span else 1.0)
    return Derived(recompute(fitted), u, dof, recompute, is_difference=True)


def _residuals(fitted: Fitted) -> Array:
    """Return y of each point minus the curve, shape (n,)."""
    return fitted.values.y - fitted.at(fitted.values.x[:, 0])[0]


def same_x(values: Values, directions: Array) -> list[Array]:
    """Return which points were taken at the same x, sorted from the lowest x.

    They are within `SAME_X` of the range of x. Set-points that differ in one way (n,) were meant to
    differ: there it is half the least step of a way, if that is less.
    """
    x = values.x[:, 0]
    width = SAME_X * float(np.ptp(x))
    if values.is_set:
        steps = [np.diff(np.sort(x[directions == way])) for way in np.unique(directions)]
        width = min([width, *(step / 2 for step in np.concatenate(steps) if step > EDGE * width)])
    order = np.argsort(x, kind="stable")
    lowest, starts = x[order], [0]
    while (end := int(np.searchsorted(lowest, lowest[starts[-1]] + width, "right"))) < len(x):
        starts.append(end)
    return np.split(order, starts[1:])


def _directions(settings: BothWays, places: Sequence[Mapping[str, CoordinateValue]]) -> Array:
    """Return 0 for each point with rising x, 1 for falling, -1 otherwise, shape (n,)."""
    ways = [
        next((i for i, value in enumerate(settings.ways)
              if settings.label in place and matches(value, place[settings.label])), -1)
        for place in places
    ]  # fmt: skip
    return np.array(ways)


def _repeatability(
    fitted: Fitted, clusters: Sequence[tuple[Array, Array]]
) -> tuple[float, float] | None:
    """Return the standard deviation of repeated values at one x, over their scale; or None."""
    residuals = _residuals(fitted) / fitted.scale
    repeated = [rows for cluster in clusters for rows in cluster if len(rows) > 1]
    dof = float(sum(len(rows) - 1 for rows in repeated))
    if not dof:
        return None
    deviations = [residuals[rows] - residuals[rows].mean() for rows in repeated]
    squares = sum(float(np.sum(deviation**2)) for deviation in deviations)
    return sqrt(squares / dof), dof


def _about_each_way(fitted: Fitted, directions: Array, fit: Fit) -> tuple[float, float]:
    """Return the pooled scatter about one curve per direction, over its scale, or about one."""
    ways = [directions == direction for direction in (0, 1)]
    try:
        curves = [fit(fitted.values.subset(rows).points()) for rows in ways]
    except DataError:
        curves = []
    if not curves or any(curve.dof <= 0 for curve in curves):
        return fitted.curve.residual_s, fitted.curve.dof
    fitted_ways = [
        Fitted(fitted.values.subset(rows), curve) for rows, curve in zip(ways, curves, strict=True)
    ]
    # Its weights are of mean 1 among those of its way alone.
    s = [
        fitted_way.curve.residual_s * float(np.mean(fitted_way.scale / fitted.scale[rows]))
        for rows, fitted_way in zip(ways, fitted_ways, strict=True)
    ]
    dof = sum(curve.dof for curve in curves)
    squares = sum(curve.dof * s_way**2 for curve, s_way in zip(curves, s, strict=True))
    return sqrt(squares / dof), dof


def _range(fitted: Fitted, at: Mapping[str, Quantity]) -> str:
    """Return the range of each regressor, in the unit of the requested value."""
    return " and ".join(
        f"{from_si(float(column.min()) + fitted.values.origin, requested.unit.symbol):.6g} to "
        f"{from_si(float(column.max()) + fitted.values.origin, requested.unit.symbol):.6g} "
        f"{requested.unit.symbol}"
        for column, requested in zip(fitted.values.x.T, at.values(), strict=True)
    )


def _shown(si: str) -> str:
    return "°C" if unit(si).dimension == "temperature" else si
