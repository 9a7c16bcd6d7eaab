"""The motion against the simulation of Wang et al., Machines 2025, 13(11), 976, at 35 Hz."""

import math

import pytest

from rigrunner_bearings.signal import kinematics

RATIO = 2 / 45
AGREEMENT = 5e-5


def test_peak_angular_velocity_of_spindle():
    assert kinematics.max_velocity(35.0, RATIO) == pytest.approx(9.3578, rel=AGREEMENT)


def test_peak_angular_acceleration_of_spindle():
    assert kinematics.max_acceleration(35.0, RATIO) == pytest.approx(2170.5367, rel=AGREEMENT)


def test_swing_angle_is_five_degrees_end_to_end():
    assert 2 * math.degrees(kinematics.max_angle(RATIO)) == pytest.approx(5, abs=0.1)
