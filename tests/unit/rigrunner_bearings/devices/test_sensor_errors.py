from dataclasses import replace

import numpy as np
import pytest

from helpers_rigs import IDEAL_SENSORS
from rigrunner_bearings.devices.simulated.parameters import ConstantErrors, SensorParameters
from rigrunner_bearings.devices.simulated.sensor_errors import (
    draw_constant_errors,
    read_angle,
    read_torque,
)

TORQUE = np.linspace(-10, 10, 20_001)
NOW = np.zeros_like(TORQUE)


def read(torque=TORQUE, elapsed=NOW, errors=None, **sensors):
    chain = replace(IDEAL_SENSORS, **sensors)
    rng = np.random.default_rng(1)
    return read_torque(torque, elapsed, chain, errors or ConstantErrors(), rng)


def test_ideal_chain_changes_nothing():
    assert np.allclose(read(), TORQUE, atol=1e-8)
    ideal = read_angle(TORQUE, IDEAL_SENSORS, np.random.default_rng(1))
    assert np.array_equal(ideal, TORQUE)


def test_gain_and_offset_are_applied():
    shown = read(errors=ConstantErrors(gain=0.003, offset_nm=-0.02))
    assert np.allclose(shown, 1.003 * TORQUE - 0.02, atol=1e-8)


def test_drift_approaches_limit_exponentially():
    elapsed = np.array([0.0, 600.0, 1e6])
    shown = read(np.zeros(3), elapsed, ConstantErrors(drift_nm=0.02))
    assert shown == pytest.approx([0.0, 0.02 * (1 - np.exp(-1)), 0.02], abs=1e-8)


def test_nonlinearity_vanishes_at_zero_and_full_scale():
    error = read(errors=ConstantErrors(nonlinearity=0.0005)) - TORQUE
    assert np.abs(error).max() == pytest.approx(0.0005 * 10, rel=1e-4)
    assert np.abs(TORQUE[np.argmax(error)]) == pytest.approx(10 / np.sqrt(3), abs=1e-3)
    assert error[[0, 10_000, 20_000]] == pytest.approx([0, 0, 0], abs=1e-8)


def test_noise_is_white_and_of_set_size():
    noise = read(np.zeros(100_000), np.zeros(100_000), noise_nm=0.02)
    assert noise.std() == pytest.approx(0.02, rel=0.02)
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.02


def test_spikes_hit_single_samples_with_set_probability():
    shown = read(np.zeros(100_000), np.zeros(100_000), spike_probability=1e-3, spike_nm=5.0)
    hit = np.flatnonzero(shown)
    assert len(hit) == pytest.approx(100, abs=35)
    sizes = np.abs(shown[hit])
    assert sizes.min() >= 1 - 1e-6
    assert sizes.max() <= 5 + 1e-6
    assert {-1.0, 1.0} == set(np.sign(shown[hit]))


def test_converter_clips_and_quantizes():
    step = 24 / 2**16
    shown = read(np.array([-20.0, 20.0, 0.4 * step, 0.6 * step]), np.zeros(4), adc_bits=16)
    assert shown == pytest.approx([-12, 12 - step, 0, step], abs=1e-12)


def test_encoder_quantizes_and_adds_noise():
    chain = replace(IDEAL_SENSORS, encoder_resolution_rad=0.01)
    shown = read_angle(np.array([0.004, 0.006, -0.016]), chain, np.random.default_rng(1))
    assert shown == pytest.approx([0, 0.01, -0.02])
    noisy = replace(IDEAL_SENSORS, encoder_noise_rad=1e-3)
    assert read_angle(np.zeros(10_000), noisy, np.random.default_rng(1)).std() == pytest.approx(
        1e-3, rel=0.03
    )


def test_constant_errors_fill_and_never_exceed_limits():
    sensors = SensorParameters()
    drawn = [draw_constant_errors(sensors, np.random.default_rng(seed)) for seed in range(2000)]
    for name, limit in (
        ("gain", 0.003), ("offset_nm", 0.02), ("drift_nm", 0.02), ("nonlinearity", 5e-4),
    ):  # fmt: skip
        values = np.array([getattr(errors, name) for errors in drawn])
        assert np.abs(values).max() <= limit
        assert values.std() == pytest.approx(limit / np.sqrt(3), rel=0.05)
