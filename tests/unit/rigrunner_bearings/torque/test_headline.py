from __future__ import annotations

from math import inf, sqrt

import pytest

from rigrunner.api.analysis import Component
from rigrunner.api.data import Estimate
from rigrunner_bearings.api.compensations import CompensatedPoint
from rigrunner_bearings.torque.headline import compensated_mean, raw_peak_mean
from unit.analysis.helpers_analysis import instrument, swing_point


def point(value, *components):
    return CompensatedPoint(10.0, 10.0, value + 1, 1.0, Estimate(value, 0.0), components)


def scatter(u, dof=9.0):
    return Component("scatter", u, dof, "t", common=False)


def shared(name, u, dof=inf):
    return Component(name, u, dof, "rectangular", common=True)


def test_value_is_mean_over_set_points():
    assert compensated_mean([point(0.7), point(0.8), point(0.6)]).value == pytest.approx(0.7)


def test_scatter_averages_out():
    mean = compensated_mean([point(0.7, scatter(0.03)), point(0.7, scatter(0.04))])
    assert mean.u == pytest.approx(sqrt(0.03**2 + 0.04**2) / 2)
    # Welch-Satterthwaite with u_i = 0.015 and 0.020: 0.025^4 / (0.015^4/9 + 0.02^4/9)
    assert mean.dof == pytest.approx(9 * 0.025**4 / (0.015**4 + 0.02**4))


def test_common_errors_do_not_average_out():
    mean = compensated_mean([point(0.7, shared("gain", 0.03)), point(0.7, shared("gain", 0.05))])
    assert mean.u == pytest.approx(0.04)
    assert mean.dof == inf


def test_different_common_errors_are_independent():
    effects = (shared("gain", 0.03), shared("drift", 0.04, 5.0))
    mean = compensated_mean([point(0.7, *effects), point(0.7, *effects)])
    assert mean.u == pytest.approx(0.05)
    assert mean.dof == pytest.approx(5 * 0.05**4 / 0.04**4)


def test_raw_mean_includes_sensor_errors():
    points = [swing_point([2.0, 2.2, 2.1], 5.0), swing_point([4.0, 4.2, 4.1], 10.0)]
    sensor = instrument(gain="1 %", drift="0.03 N·m", nonlinearity="0.1 %")
    mean = raw_peak_mean(points, sensor, zeroed=True)
    scatter = 0.1 / sqrt(3) / sqrt(2)
    gain, drift, bend = (a / sqrt(3) for a in (0.031, 0.03, 0.01))
    assert mean.value == pytest.approx(3.1)
    assert mean.u == pytest.approx(sqrt(scatter**2 + gain**2 + drift**2 + bend**2), rel=1e-4)


def test_offset_counts_without_zero_reading():
    points = [swing_point([2.0, 2.0, 2.0], 5.0)]
    accuracy = {"gain": "0 %", "offset": "0.06 N·m", "drift": "0 N·m", "nonlinearity": "0 %"}
    sensor = instrument().model_validate(
        {"channel": "t.q", "serial": "1", "full_scale": "10 N·m", "accuracy": accuracy}
    )
    assert raw_peak_mean(points, sensor, zeroed=True).u == 0
    assert raw_peak_mean(points, sensor, zeroed=False).u == pytest.approx(0.06 / sqrt(3))
