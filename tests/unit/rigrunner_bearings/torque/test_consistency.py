"""Inconsistent set-points, against Birge's ratio computed by hand."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from rigrunner.api.analysis import Component
from rigrunner.api.data import Estimate
from rigrunner_bearings.api.compensations import CompensatedPoint
from rigrunner_bearings.torque.consistency import TREND, agreement

HERTZ = np.array([1.0, 3.0, 5.0, 8.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0])


def points(torques, own_u=0.003):
    part = Component("scatter", own_u, inf, "normal", common=False)
    common = Component("gain", 0.1, inf, "normal", common=True)
    return [
        CompensatedPoint(f, f, 5.0, 4.0, Estimate(float(t), 0.1), (part, common))
        for f, t in zip(HERTZ, torques, strict=True)
    ]


def test_plausible_trend_of_friction_is_consistent():
    check = agreement(points(0.9 - 0.05 * np.sqrt(HERTZ) + 0.002 * HERTZ))
    assert check.ok
    assert check.value == pytest.approx(0.0, abs=1e-9)


def test_excess_scatter_widens_uncertainty_by_birge_ratio():
    deviations = np.zeros(10)
    deviations[6] = 0.05
    check = agreement(points(0.8 + deviations))
    sigma = np.hypot(0.003, TREND * 0.805)
    basis = np.stack([np.ones(10), HERTZ, np.sqrt(HERTZ)], axis=1)
    projected = np.eye(10) - basis @ np.linalg.solve(basis.T @ basis, basis.T)
    ratio = 0.05 / sigma * np.sqrt(projected[6, 6] / 7)
    assert check.value == pytest.approx(ratio)
    assert not check.ok
    assert check.common
    assert "20 Hz is off their trend by +0.0" in check.text
    widened = np.hypot(sigma, [bias.u for bias in check.biases])
    np.testing.assert_allclose(widened, ratio * sigma)


def test_false_alarm_rate_is_as_stated():
    rng = np.random.default_rng(3)
    sigma = np.hypot(0.003, TREND * 0.8)
    alarms = sum(
        not agreement(points(0.8 + sigma * rng.standard_normal(10))).ok for _ in range(500)
    )
    assert alarms <= 12, "1 % of 500, and what chance may add"


def test_few_frequencies_are_not_checked():
    check = agreement(points([0.8] * 10)[:4])
    assert check.ok
    assert check.text == "not checked: fewer than 5 frequencies"
