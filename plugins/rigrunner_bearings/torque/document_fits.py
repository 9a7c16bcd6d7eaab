"""The fits of peaks over frequency in the content of `result.json`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.signal.as_json.curves import curve_of
from rigrunner.signal.as_json.values import plain
from rigrunner.signal.bands import bands

if TYPE_CHECKING:
    from rigrunner.api import Curve, Points
    from rigrunner.signal.as_json.values import Json
    from rigrunner_bearings.api.torque import FittedTorque


def fit(fitted: FittedTorque) -> Json:
    """Return a fit with its points; its curve is null where there is none."""
    return {
        "name": fitted.name,
        "problem": fitted.problem or None,
        "points": {
            "x": {"values": plain(fitted.points.x), "unit": fitted.points.x_unit},
            "y": {"values": plain(fitted.points.y), "unit": fitted.points.y_unit},
            "u_y": {"values": plain(fitted.points.u_y), "unit": fitted.points.y_unit},
        },
        "curve": None if fitted.curve is None else curve_of(fitted.curve),
        "at_the_points": None
        if fitted.curve is None
        else _at_the_points(fitted.curve, fitted.points),
    }


def _at_the_points(curve: Curve, points: Points) -> Json:
    """Return the curve and the half-widths of its bands at each x, in the unit of y."""
    found = bands(curve, points.x)
    return {
        "curve": plain(found.value),
        "confidence_95": plain(found.confidence),
        "prediction_95": plain(found.prediction),
        "unit": points.y_unit,
    }
