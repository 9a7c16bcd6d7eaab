from __future__ import annotations

from math import sqrt

import numpy as np
import pytest

from rigrunner.api.uncertainty import Corrected, Effect, Input, MeasurementModel
from rigrunner.signal.propagation import propagate
from rigrunner_bearings.api.compensations import CompensatedPoint
from rigrunner_bearings.signal.mean_model import mean_model

RESONANCE = Input("fn", 400.0, 4.0, 12, unit="Hz", common=True)


def point(value, *effects, correlation=None):
    inputs = tuple(effect.input for effect in effects)
    model = MeasurementModel(inputs, Corrected(value, effects), correlation)
    propagated = propagate(model)
    return CompensatedPoint(
        10, 10, value, 0, propagated.estimate, propagated.components, model=model
    )


def mean_of(*points):
    return propagate(mean_model(points)).estimate


def repeatability(u, dof=9.0):
    return Effect(Input("repeatability", 0.0, u, dof), 1.0)


def test_opposite_effects_of_common_error_cancel():
    mean = mean_of(point(0.7, Effect(RESONANCE, 0.01)), point(0.9, Effect(RESONANCE, -0.01)))
    assert mean.value == pytest.approx(0.8)
    assert mean.u == pytest.approx(0, abs=1e-12)


def test_common_errors_stay_and_independent_ones_average():
    points = [point(0.7, Effect(RESONANCE, 0.01), repeatability(0.03)) for _ in range(4)]
    mean = mean_of(*points)
    assert mean.u == pytest.approx(sqrt(0.04**2 + 0.03**2 / 4))
    assert mean.dof == pytest.approx(mean.u**4 / (0.04**4 / 12 + 4 * (0.03 / 4) ** 4 / 9))


def test_covariance_of_fit_is_kept():
    """The mean of two points of a line is the line in the middle, not two independent points."""
    a, b = (
        Input(name, 1.0, u, 6, common=True, line="fit", ensemble="fit")
        for name, u in (("a", 0.02), ("b", 0.01))
    )
    r = np.array([[1.0, -0.8], [-0.8, 1.0]])
    points = [point(1, Effect(a, 1.0), Effect(b, x), correlation=r) for x in (1.0, 5.0)]
    mean = mean_of(*points)
    variance = 0.02**2 + (3 * 0.01) ** 2 - 2 * 0.8 * 0.02 * 0.03
    assert mean.u == pytest.approx(sqrt(variance))
    assert mean.dof == pytest.approx(6)


def test_ensembles_of_separate_points_stay_separate():
    def fitted():
        parts = (Input(name, 0.0, 0.1, 5, ensemble="own fit") for name in "ab")
        return point(0.7, *(Effect(part, 1.0) for part in parts))

    assert mean_of(fitted(), fitted()).dof == pytest.approx(10)


def test_differing_common_input_is_refused():
    other_resonance = Effect(Input("fn", 401.0, 4.0, 12, unit="Hz", common=True), 0.01)
    with pytest.raises(ValueError, match="fn is common to all points"):
        mean_of(point(0.7, Effect(RESONANCE, 0.01)), point(0.7, other_resonance))


def test_mean_model_evaluates_trials():
    model = mean_model([point(0.7, Effect(RESONANCE, 0.01), repeatability(0.03)) for _ in range(2)])
    assert len(model.inputs) == 3
    trials = {x.name: np.array([x.value, x.value + x.u]) for x in model.inputs}
    assert model.equation(trials) == pytest.approx([0.7, 0.7 + 0.04 + 0.03])
