"""The part of `result.json` that says whether Monte Carlo agrees with the GUM."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.signal.as_json.values import estimate, quantity

if TYPE_CHECKING:
    from rigrunner.signal.as_json.values import Json
    from rigrunner_bearings.api.validation import Agreement, Validation

TORQUE = "N·m"


def validation(found: Validation) -> Json:
    """Return both checks of a method's result."""
    equation, pipeline = found.equation, found.pipeline
    return {
        "method": found.method,
        "agrees": found.agrees,
        "statements": list(found.statements),
        "significant_digits": found.digits,
        "seed": found.seed,
        "equation": {
            "trials": equation.trials,
            "stable": equation.stable,
            "mean": _agreement(equation.mean),
            "points": [_agreement(each) for each in equation.points],
        },
        "pipeline": {
            "draws": pipeline.draws,
            "refused": pipeline.refused,
            "through_the_data": list(pipeline.through_the_data),
            "as_effects": list(pipeline.as_effects),
            "mean": _agreement(pipeline.mean),
            "points": [_agreement(each) for each in pipeline.points],
        },
    }


def _agreement(found: Agreement) -> Json:
    frequency = found.set_frequency_hz
    return {
        "set_frequency": None if frequency is None else quantity(frequency, "Hz"),
        "gum": estimate(found.gum),
        "mean": quantity(found.mean, TORQUE),
        "standard_uncertainty": quantity(found.u, TORQUE),
        "interval_95": {"low": found.low, "high": found.high, "unit": TORQUE},
        "ends_differ_by": quantity(found.apart, TORQUE),
        "tolerance": quantity(found.tolerance, TORQUE),
        "resolution": quantity(found.resolution, TORQUE),
        "agrees": found.agrees,
    }
