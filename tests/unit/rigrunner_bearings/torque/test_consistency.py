"""Set-points that contradict each other, against Birge's ratio by hand."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from rigrunner.api.analysis import Component
from rigrunner.api.data import Estimate
from rigrunner_bearings.api.compensations import CompensatedPoint
from rigrunner_bearings.torque.consistency import TREND, agreement

HERTZ = np.array([1.0, 3.0, 5.0, 8.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0])


def points(torques, own=0.003):
    part = Component("scatter", own, inf, "normal", common=False)
    common = Component("gain", 0.1, inf, "normal", common=True)
    return [
        CompensatedPoint(f, f, 5.0, 4.0, Estimate(float(t), 0.1), (part, common))
        for f, t in zip(HERTZ, torques, strict=True)
    ]


def test_a_trend_that_friction_may_have_is_no_contradiction():
    check = agreement(points(0.9 - 0.05 * np.sqrt(HERTZ) + 0.002 * HERTZ))
    assert check.ok
    assert check.value == pytest.approx(0.0, abs=1e-9)


def test_scatter_beyond_the_own_uncertainties_widens_them_by_the_birge_ratio():
    off = np.zeros(10)
    off[6] = 0.05
    check = agreement(points(0.8 + off))
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


def test_false_alarms_are_as_rare_as_said():
    rng = np.random.default_rng(3)
    sigma = np.hypot(0.003, TREND * 0.8)
    alarms = sum(
        not agreement(points(0.8 + sigma * rng.standard_normal(10))).ok for _ in range(500)
    )
    assert alarms <= 12, "1 % of 500, and what chance may add"


def test_few_frequencies_show_no_trend():
    check = agreement(points([0.8] * 10)[:4])
    assert check.ok
    assert check.text == "not checked: fewer than 5 frequencies"
