"""Fitted curves in the content of `result.json`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.analysis import Chosen
from rigrunner.signal.as_json.values import degrees_of_freedom, number, plain

if TYPE_CHECKING:
    from rigrunner.api.analysis import Curve
    from rigrunner.signal.as_json.values import Json


def curve_of(curve: Curve) -> Json:
    """Return a curve with its coefficients, covariance and goodness."""
    chosen_from: Json | None = None
    if isinstance(curve, Chosen):
        chosen_from = {
            "criterion": curve.criterion,
            "candidates": [
                {
                    "formula": candidate.formula,
                    "parameters": candidate.parameters,
                    "score": number(candidate.score),
                    "residual_standard_deviation": number(candidate.residual_s),
                    "chosen": candidate.chosen,
                    "problem": candidate.problem or None,
                }
                for candidate in curve.candidates
            ],
        }
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
        "chosen_from": chosen_from,
    }
