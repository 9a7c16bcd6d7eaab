import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers_thorough import examples
from rigrunner_bearings.signal import kinematics

RATIO = 2 / 45
PHASE = 2 * np.pi * np.arange(100_000) / 100_000
ratios = st.floats(0.001, 0.5)


def test_angle_is_that_of_crank_and_bar_triangle():
    pin = 45 + 2 * np.exp(1j * PHASE)  # mm, seen from the bar's axis
    assert np.allclose(kinematics.swing_angle(PHASE, RATIO), np.angle(pin), atol=1e-15)


def test_joint_function_equals_separate_ones_bit_for_bit():
    angle, velocity = kinematics.angle_and_velocity(PHASE, 7.0, RATIO)
    np.testing.assert_array_equal(angle, kinematics.swing_angle(PHASE, RATIO))
    np.testing.assert_array_equal(velocity, kinematics.angular_velocity(PHASE, 7.0, RATIO))


@settings(deadline=None, max_examples=examples(30))
@given(ratio=ratios, phase=st.floats(0, 2 * math.pi))
def test_velocity_and_acceleration_are_derivatives(ratio, phase):
    step, frequency = 1e-4, 7.0
    phases = phase + step * np.array([-1.0, 0.0, 1.0])
    omega = 2 * math.pi * frequency
    before, _, after = kinematics.swing_angle(phases, ratio)
    velocity = kinematics.angular_velocity(phases, frequency, ratio)
    assert velocity[1] == pytest.approx(omega * (after - before) / (2 * step), rel=1e-6, abs=1e-5)
    slope = omega * (velocity[2] - velocity[0]) / (2 * step)
    acceleration = kinematics.angular_acceleration(phases, frequency, ratio)[1]
    assert acceleration == pytest.approx(slope, rel=1e-5, abs=1e-2)


@settings(deadline=None, max_examples=examples(20))
@given(ratio=ratios)
def test_extremes_equal_those_of_sampled_motion(ratio):
    angle = kinematics.swing_angle(PHASE, ratio)
    velocity = kinematics.angular_velocity(PHASE, 3.0, ratio)
    acceleration = kinematics.angular_acceleration(PHASE, 3.0, ratio)
    assert kinematics.max_angle(ratio) == pytest.approx(angle.max(), rel=1e-8)
    assert kinematics.max_velocity(3.0, ratio) == pytest.approx(velocity.max(), rel=1e-8)
    assert kinematics.max_speed(3.0, ratio) == pytest.approx(np.abs(velocity).max(), rel=1e-8)
    assert kinematics.max_acceleration(3.0, ratio) == pytest.approx(acceleration.max(), rel=1e-8)


def test_bar_reverses_at_reversal_phase_and_rises_at_phase_zero():
    reversal = kinematics.reversal_phase(RATIO)
    reversals = np.array([reversal, -reversal])
    extremes = kinematics.swing_angle(reversals, RATIO)
    assert np.allclose(kinematics.angular_velocity(reversals, 35.0, RATIO), 0, atol=1e-12)
    assert extremes == pytest.approx([kinematics.max_angle(RATIO), -kinematics.max_angle(RATIO)])
    assert kinematics.angular_velocity(np.zeros(1), 35.0, RATIO)[0] > 0
    assert math.degrees(reversal) == pytest.approx(92.5473, abs=1e-4)


def test_motion_is_sum_of_its_harmonics():
    order = np.arange(1, 20)[:, None]
    series = ((-1.0) ** (order + 1) * RATIO**order / order * np.sin(order * PHASE)).sum(axis=0)
    assert np.allclose(kinematics.swing_angle(PHASE, RATIO), series, atol=1e-15)


@given(ratio=ratios)
def test_half_angle_form_equals_direct_form(ratio):
    phase = np.append(PHASE - math.pi, [0.0, math.pi, 7.0])
    angle, velocity = kinematics.by_half_angle(phase, ratio)
    reference = kinematics.angle_and_velocity(phase, 1.0, ratio)
    for result, expected in zip((angle, velocity), reference, strict=True):
        np.testing.assert_allclose(result, expected, rtol=0, atol=1e-14 * np.abs(expected).max())
