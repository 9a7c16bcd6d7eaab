"""The no-load peaks over frequency, the curves fitted to them, and the residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.figures import Axis, Figure, Mark, Picture, Series
from rigrunner.signal.thinning import places_of_extremes
from rigrunner.signal.uncertainty import coverage_factor
from rigrunner_reports.figures.results import MOST_POINTS, THINNED
from rigrunner_reports.numbers import fixed, with_sign

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Curve, Points
    from rigrunner.signal.thinning import Places
    from rigrunner_bearings.api.torque import FittedTorque

SAMPLES = 120
MILLI = 1e3
PEAKS = "mean peak of the kept swings"
CAPTION = (
    "Torque of the rig itself over frequency, with the fits of the procedure. The bands are U "
    "(95 %) of each curve, from its whole covariance; they say how well the curve is known if "
    "its form is right. Residuals that follow a pattern, not chance, show a form that is wrong."
)


def fitted_peaks(fits: Sequence[FittedTorque]) -> Picture:
    """Return the picture of fits to the same points; at least one must have a curve."""
    curves = [(fit.name, fit.curve) for fit in fits if fit.curve is not None]
    points = fits[0].points
    shown = places_of_extremes(
        points.y, *(curve.residuals for _, curve in curves), most=MOST_POINTS
    )
    frequency = Axis("frequency", "Hz", low=0.0)
    peaks = Series.over(points.x[shown], points.y[shown], PEAKS)
    residuals = (
        Series.over(points.x[shown], MILLI * curve.residuals[shown], name, "joined")
        for name, curve in curves
    )
    drawn, about_zero = [], []
    for name, curve in curves:
        x = np.linspace(*curve.valid_x, SAMPLES)
        value, u = curve.predict(x)
        k = coverage_factor(curve.dof)
        drawn.append(Series.over(x, value, name, "line", U=u * k))
        about_zero.append(Series.over(x, 0 * x, name, "line", U=MILLI * u * k))
    panels = (
        Figure("Peaks and fits", frequency, Axis("no-load peak", "N·m"), (*drawn, peaks)),
        Figure(
            "Peaks minus fit",
            frequency,
            Axis("residual", "mN·m"),
            (*about_zero, *residuals),
            (Mark("y", 0.0),),
        ),
    )
    caption = CAPTION + (THINNED if len(shown) < len(points.x) else "")
    return Picture(caption, _alt(points, curves, shown), panels)


def _alt(points: Points, curves: Sequence[tuple[str, Curve]], shown: Places) -> str:
    drawn = zip(points.x[shown], points.y[shown], strict=True)
    peaks = ", ".join(f"{x:.4g} Hz {fixed(y, 3)}" for x, y in drawn)
    residuals = " ".join(
        f"Residuals of {name} in mN·m: "
        + ", ".join(with_sign(MILLI * residual, 0) for residual in curve.residuals[shown])
        + "."
        for name, curve in curves
    )
    return f"No-load peaks in N·m: {peaks}. {residuals}"
