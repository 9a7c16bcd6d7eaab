"""Fits and their curves in the content of `result.json`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.analysis.document_values import degrees_of_freedom, number, plain
from rigrunner.api.analysis import Chosen
from rigrunner.signal.bands import bands

if TYPE_CHECKING:
    from rigrunner.analysis.document_values import Json
    from rigrunner.api.analysis import Curve
    from rigrunner.api.data import Points
    from rigrunner.api.torque import FittedTorque


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


def curve_of(curve: Curve) -> Json:
    """Return a curve with its coefficients, covariance and goodness."""
    standard = np.sqrt(np.diag(curve.covariance))
    return {
        "formula": curve.formula,
        "coefficients": {
            name: {"value": number(value), "standard_uncertainty": number(u), "unit": unit}
            for name, value, u, unit in zip(
                curve.names, curve.coefficients, standard, curve.units, strict=True
            )
        },
        "covariance": plain(curve.covariance),
        "degrees_of_freedom": degrees_of_freedom(curve.dof),
        "residual_standard_deviation": number(curve.residual_s),
        "residuals": plain(curve.residuals),
        "root_mean_square_error": number(float(np.sqrt(np.mean(curve.residuals**2)))),
        "r_squared": number(curve.r_squared),
        "valid_from": number(curve.valid_x[0]),
        "valid_to": number(curve.valid_x[1]),
        "chosen_from": _candidates(curve) if isinstance(curve, Chosen) else None,
    }


def _candidates(curve: Chosen) -> Json:
    return {
        "criterion": curve.criterion,
        "candidates": [
            {
                "formula": each.formula,
                "parameters": each.parameters,
                "score": number(each.score),
                "residual_standard_deviation": number(each.residual_s),
                "chosen": each.chosen,
                "problem": each.problem or None,
            }
            for each in curve.candidates
        ],
    }
