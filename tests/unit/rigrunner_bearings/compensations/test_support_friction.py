import numpy as np
import pytest

from rigrunner_bearings.compensations.support_friction import make_friction
from rigrunner_bearings.compensations.swing import make_swing, strokes

SWING = make_swing(2 / 45)
RIGID = np.zeros(SWING.size)
KNOWN_HZ = 12.0


def dry(angle, level=0.8, slip=0.005):
    result = np.empty_like(angle)
    for stroke, sign in zip(strokes(angle), (1, -1), strict=True):
        result[stroke.index] = sign * level * (1 - 2 * np.exp(-stroke.distance_rad / slip))
    return result


DRY = dry(SWING.angle_rad)
SPEED = np.abs(SWING.velocity_per_hz)


def test_separates_proportional_and_viscous_growth():
    growth = 0.3 * SPEED * DRY + 0.2 * SWING.velocity_per_hz
    friction = make_friction(SWING, RIGID, DRY, growth, KNOWN_HZ)
    assert friction.growth_s == pytest.approx(0.3)
    assert friction.viscous_nms == pytest.approx(0.2)


def test_without_twist_torque_is_as_measured():
    growth = 0.3 * SPEED * DRY + 0.2 * SWING.velocity_per_hz
    friction = make_friction(SWING, RIGID, DRY, growth, KNOWN_HZ)
    np.testing.assert_allclose(friction.torque(20.0, RIGID, 1.0), DRY + 20 * growth, atol=1e-9)
    np.testing.assert_allclose(friction.change(20.0, RIGID), 0, atol=1e-9)


def test_friction_follows_load_by_its_share():
    twist = 0.002 * np.sin(2 * np.pi * np.arange(SWING.size) / SWING.size + 0.4)
    rate = 0.002 * 2 * np.pi * 20 * np.cos(2 * np.pi * np.arange(SWING.size) / SWING.size + 0.4)
    friction = make_friction(SWING, RIGID, DRY, 0.2 * SWING.velocity_per_hz, KNOWN_HZ)
    for share in (0.0, 0.5, 1.0):
        velocity = 20 * SWING.velocity_per_hz - share * rate
        expected = dry(SWING.angle_rad - share * twist) + 0.2 * velocity
        torque = friction.torque(20.0, twist, share)
        np.testing.assert_allclose(torque, expected, atol=2e-3)


@pytest.mark.parametrize("frequency_hz", [1.0, 20.0])
def test_change_equals_difference_bit_for_bit(frequency_hz):
    """Terms that do not depend on the twist are computed once: faster, with the same result."""
    twist = 0.002 * np.sin(2 * np.pi * np.arange(SWING.size) / SWING.size + 0.4)
    growth = 0.3 * SPEED * DRY + 0.2 * SWING.velocity_per_hz
    friction = make_friction(SWING, twist / 7, DRY, growth, KNOWN_HZ)
    full, none = (friction.torque(frequency_hz, twist, share) for share in (1.0, 0.0))
    np.testing.assert_array_equal(friction.change(frequency_hz, twist), full - none)


def test_twist_of_slow_swing_changes_nothing():
    twist = 1e-4 * np.sign(SWING.velocity_per_hz) * (1 - np.exp(-SPEED / 0.02))
    friction = make_friction(SWING, twist, DRY, np.zeros(SWING.size), KNOWN_HZ)
    np.testing.assert_allclose(friction.change(0.0, twist), 0, atol=1e-9)


def test_friction_level_is_that_of_sliding_stroke():
    friction = make_friction(SWING, RIGID, DRY, np.zeros(SWING.size), KNOWN_HZ)
    assert np.median(np.abs(friction.slow_nm)) == pytest.approx(0.8, rel=0.01)


def test_extrapolation_noise_is_kept_out():
    """The line is known at 12 Hz; an error of its slope there has the opposite sign at rest."""
    rng = np.random.default_rng(1)
    wrong = 1e-3 * rng.standard_normal(SWING.size)
    growth = 0.2 * SWING.velocity_per_hz + wrong
    friction = make_friction(SWING, RIGID, DRY - KNOWN_HZ * wrong, growth, KNOWN_HZ)
    assert np.std(friction.dry_nm - DRY) > 0.01, "there is noise to keep out"
    assert np.std(friction.torque(0.0, RIGID, 1.0) - DRY) < 0.001
    measured = friction.measured_torque(20.0, RIGID, 1.0)
    np.testing.assert_allclose(measured, friction.dry_nm + 20 * growth, atol=1e-12)
