"""Expected torque relative to the instrument's range, and expected disk space."""

from __future__ import annotations

import math

import numpy as np
import pytest

from helpers_language import PROCEDURE, STATION, edited
from rigrunner.plan import expected_readings, predict
from unit.rigrunner_bearings.torque.helpers_planning import Lookup, planned

RATIO, INERTIA, FRICTION_NM, DAMPING = 2 / 45, 0.00233, 0.76, 0.31


def prediction_of(text=PROCEDURE, station=STATION):
    procedure, loaded, plan, to_come = planned(text, station=station)
    expected = expected_readings(procedure.model, to_come, Lookup())
    return predict(plan, expected, loaded.register)


def rig_torque_nm(frequency_hz):
    """The same by numerical differentiation of the swing, independent of the code's formulas."""
    time_s = np.linspace(0, 1 / frequency_hz, 20_001)
    phase = 2 * math.pi * frequency_hz * time_s
    angle = np.arctan2(RATIO * np.sin(phase), 1 + RATIO * np.cos(phase))
    speed = np.gradient(angle, time_s, edge_order=2)
    acceleration = np.gradient(speed, time_s, edge_order=2)
    return INERTIA * acceleration.max() + FRICTION_NM + DAMPING * np.abs(speed).max()


def test_peak_is_sum_of_rig_and_limit():
    torques = prediction_of().readings

    assert [torque.recording for torque in torques] == ["001_2Hz", "002_10Hz"]
    assert [torque.cycle_frequency_hz for torque in torques] == [2.0, 10.0]
    for torque in torques:
        expected_nm = rig_torque_nm(torque.cycle_frequency_hz) + 0.95
        assert torque.peak == pytest.approx(expected_nm, rel=1e-5)
        assert torque.share == pytest.approx(expected_nm / 10, rel=1e-5)


def test_without_limit_peak_is_that_of_rig():
    text = PROCEDURE[: PROCEDURE.index("acceptance:")]
    assert prediction_of(text).readings[1].peak == pytest.approx(rig_torque_nm(10.0), rel=1e-5)


def test_overload_is_reported():
    small = edited(STATION, ("full_scale: 10 N·m", "full_scale: 2.5 N·m"))

    assert prediction_of().overloads == ()
    assert [overload.recording for overload in prediction_of(station=small).overloads] == [
        "002_10Hz"
    ]


def test_disk_space_covers_all_samples_of_all_channels():
    channels, bytes_per_sample, rate_hz = 2, 8, 1000

    expected = round((15.5 + 3.1) * rate_hz) * channels * bytes_per_sample
    assert prediction_of().disk_bytes == expected
