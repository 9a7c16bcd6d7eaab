"""JCGM 100:2008 (the GUM), H.2: resistance, reactance and impedance, measured simultaneously.

From the five sets of readings of Table H.2; the published results are in Table H.3.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest

from rigrunner.api.uncertainty import Input, MeasurementModel
from rigrunner.signal.monte_carlo.adaptive import Adaptive
from rigrunner.signal.monte_carlo.adaptive import propagate as by_trials
from rigrunner.signal.monte_carlo.model import output_of
from rigrunner.signal.propagation import propagate, sensitivities

VOLT = (5.007, 4.994, 5.005, 4.990, 4.999)
MILLIAMPERE = (19.663, 19.639, 19.640, 19.685, 19.678)
RADIAN = (1.0456, 1.0438, 1.0468, 1.0428, 1.0433)
READINGS = np.array([VOLT, np.array(MILLIAMPERE) / 1000, RADIAN])
EQUATIONS = {
    "R": lambda x: x["V"] / x["I"] * np.cos(x["phi"]),
    "X": lambda x: x["V"] / x["I"] * np.sin(x["phi"]),
    "Z": lambda x: x["V"] / x["I"],
}
COVARIANCE = np.cov(READINGS) / READINGS.shape[1]


def model(name):
    values, u = READINGS.mean(axis=1), np.sqrt(np.diag(COVARIANCE))
    inputs = tuple(
        Input(symbol, value, u_mean)
        for symbol, value, u_mean in zip(("V", "I", "phi"), values, u, strict=True)
    )
    return MeasurementModel(inputs, EQUATIONS[name], np.corrcoef(READINGS))


def test_inputs_of_table_h_2():
    means, u = READINGS.mean(axis=1), np.sqrt(np.diag(COVARIANCE))
    assert means == pytest.approx([4.9990, 19.6610e-3, 1.04446], abs=5e-7)
    assert u == pytest.approx([0.0032, 0.0095e-3, 0.00075], rel=0.01)
    r = np.corrcoef(READINGS)
    assert [r[0, 1], r[0, 2], r[1, 2]] == pytest.approx([-0.36, 0.86, -0.65], abs=0.01)


@pytest.mark.parametrize(
    ("name", "value", "u"),
    [("R", 127.732, 0.071), ("X", 219.847, 0.295), ("Z", 254.260, 0.236)],
)
def test_results_of_table_h_3(name, value, u):
    estimate = propagate(model(name)).estimate
    assert estimate.value == pytest.approx(value, abs=1e-3)
    assert estimate.u == pytest.approx(u, abs=1e-3)


@pytest.mark.parametrize(
    ("one", "other", "r"), [("R", "X", -0.588), ("R", "Z", -0.485), ("X", "Z", 0.993)]
)
def test_correlations_of_table_h_3(one, other, r):
    a, b = (sensitivities(model(name)) for name in (one, other))
    u = sqrt(a @ COVARIANCE @ a) * sqrt(b @ COVARIANCE @ b)
    assert a @ COVARIANCE @ b / u == pytest.approx(r, abs=2e-3)


def test_trials_of_correlated_inputs_agree():
    """The equation is nearly linear there, so JCGM 101 gives the values of Table H.3."""
    settings = Adaptive(least_trials=200_000, most_trials=200_000)
    trials = by_trials(output_of(model("R")), settings)
    assert trials.mean == pytest.approx(127.732, abs=2e-3)
    assert trials.u == pytest.approx(0.071, abs=1e-3)
