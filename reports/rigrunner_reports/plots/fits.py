"""The no-load peaks over frequency, the curves fitted to them, and what is left over."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.uncertainty import coverage_factor
from rigrunner_reports.numbers import fixed, with_sign
from rigrunner_reports.plots.canvas import INK, OTHERS, PRIMARY, Plot, draw
from rigrunner_reports.plots.thinning import MOST_POINTS, THINNED, places_of_extremes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rigrunner.api.analysis import Curve
    from rigrunner.api.data import Array, Points
    from rigrunner.api.results import FittedTorque
    from rigrunner_reports.plots.canvas import Line
    from rigrunner_reports.plots.thinning import Places

SAMPLES = 120
MILLI = 1e3
BAND_OPACITY = 0.15


def fitted_peaks(fits: Sequence[FittedTorque]) -> Plot:
    """Return the figure of the fits, all of the same points; at least one must have a curve."""
    curves = [(fit.name, fit.curve) for fit in fits if fit.curve is not None]
    points = fits[0].points
    shown = places_of_extremes(
        points.y, *(curve.residuals for _, curve in curves), most=MOST_POINTS
    )

    def paint(figure: Figure) -> None:
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1.25))
        _peaks(upper, points, shown)
        for (name, curve), line in zip(curves, (PRIMARY, *OTHERS), strict=False):
            _curve(upper, name, curve, line)
            _residuals(lower, curve, points, shown, line)
        upper.set(ylabel="no-load peak / N·m", title="Peaks and fits")
        upper.legend(loc="upper left")
        lower.axhline(0, color=INK, linewidth=0.6)
        lower.set(xlabel="frequency / Hz", ylabel="residual / mN·m", title="Peaks minus fit")
        lower.set_xlim(left=0)

    caption = _caption() + (THINNED if len(shown) < len(points.x) else "")
    return Plot(caption=caption, alt=_alt(points, curves, shown), svg=draw(paint, 4.1))


def _peaks(axes: Axes, points: Points, shown: Places) -> None:
    axes.plot(
        points.x[shown],
        points.y[shown],
        label="mean peak of the kept swings",
        color=INK,
        linestyle="",
        marker="o",
        markersize=5,
        markerfacecolor="white",
    )


def _curve(axes: Axes, name: str, curve: Curve, line: Line) -> None:
    x = np.linspace(*curve.valid_x, SAMPLES)
    value, u = curve.predict(x)
    axes.plot(x, value, color=line.color, linestyle=line.linestyle, label=name)
    _band(axes, x, value, u * _factor(curve), line)


def _residuals(axes: Axes, curve: Curve, points: Points, shown: Places, line: Line) -> None:
    x = np.linspace(*curve.valid_x, SAMPLES)
    _, u = curve.predict(x)
    _band(axes, x, np.zeros(SAMPLES), MILLI * u * _factor(curve), line)
    axes.plot(
        points.x[shown],
        MILLI * curve.residuals[shown],
        color=line.color,
        linestyle=line.linestyle,
        linewidth=0.9,
        marker=line.marker,
    )


def _band(axes: Axes, x: Array, middle: Array, half_width: Array, line: Line) -> None:
    axes.fill_between(
        x,
        middle - half_width,
        middle + half_width,
        color=line.color,
        alpha=BAND_OPACITY,
        linewidth=0,
    )


def _factor(curve: Curve) -> float:
    factor = coverage_factor(curve.dof)
    return factor if isfinite(factor) else 0.0


def _caption() -> str:
    return (
        "Torque of the rig itself over frequency, with the fits of the procedure. The bands are U "
        "(95 %) of each curve, from its whole covariance; they say how well the curve is known if "
        "its form is right. Residuals that follow a pattern, not chance, show a form that is wrong."
    )


def _alt(points: Points, curves: Sequence[tuple[str, Curve]], shown: Places) -> str:
    drawn = zip(points.x[shown], points.y[shown], strict=True)
    peaks = ", ".join(f"{x:.4g} Hz {fixed(y, 3)}" for x, y in drawn)
    left = " ".join(
        f"Residuals of {name} in mN·m: "
        + ", ".join(with_sign(MILLI * each, 0) for each in curve.residuals[shown])
        + "."
        for name, curve in curves
    )
    return f"No-load peaks in N·m: {peaks}. {left}"
