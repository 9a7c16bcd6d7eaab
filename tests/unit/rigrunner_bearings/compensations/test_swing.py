import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner_bearings.compensations.swing import (
    at_same_distance,
    interpolated,
    make_swing,
    strokes,
)

SWING = make_swing(2 / 45)


def test_velocity_and_acceleration_are_the_angles_derivatives():
    harmonic = 2j * np.pi * np.arange(SWING.size // 2 + 1)
    spectrum = np.fft.rfft(SWING.angle_rad)
    velocity = np.fft.irfft(spectrum * harmonic, SWING.size)
    acceleration = np.fft.irfft(spectrum * harmonic**2, SWING.size)
    np.testing.assert_allclose(SWING.velocity_per_hz, velocity, atol=1e-9)
    np.testing.assert_allclose(SWING.acceleration_per_hz2, acceleration, atol=1e-6)


def test_strokes_cover_all_samples_once():
    forward, backward = strokes(SWING.angle_rad)
    together = np.sort(np.concatenate([forward.index, backward.index]))
    assert together.tolist() == list(range(SWING.size))
    assert np.all(SWING.velocity_per_hz[forward.index[1:]] > 0)
    assert np.all(SWING.velocity_per_hz[backward.index[1:]] < 0)


def test_distance_starts_at_reversal():
    for stroke in strokes(SWING.angle_rad):
        assert stroke.distance_rad[0] == 0
        assert np.all(np.diff(stroke.distance_rad) >= 0)
        assert stroke.distance_rad[-1] == pytest.approx(2 * np.arcsin(2 / 45), rel=1e-4)


@given(st.floats(-0.01, 0.01), st.integers(0, 40))
def test_function_of_distance_is_recovered_on_shifted_swing(offset, late):
    def friction(angle):
        result = np.empty_like(angle)
        for stroke, sign in zip(strokes(angle), (1, -1), strict=True):
            result[stroke.index] = sign * (1 - 2 * np.exp(-stroke.distance_rad / 0.005))
        return result

    other_angle = np.roll(SWING.angle_rad, late) + offset
    moved = at_same_distance(friction(SWING.angle_rad), strokes(SWING.angle_rad), other_angle)
    np.testing.assert_allclose(moved, friction(other_angle), atol=1e-5)


def test_interpolation_keeps_the_harmonics():
    coarse, fine = (2 * np.pi * np.arange(n) / n for n in (64, 256))
    expected = 1 + np.cos(5 * fine)
    np.testing.assert_allclose(interpolated(1 + np.cos(5 * coarse), 256), expected, atol=1e-12)
