"""Bias of the starting torque that is read from a noisy curve."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner.api.filters import LowPass
from rigrunner_bearings.compensations.bearing import (
    MeanSwing,
    Pair,
    Reversals,
    bearing_torque,
    replicates,
    reversals,
)
from rigrunner_bearings.compensations.drive_line import DriveLine
from rigrunner_bearings.compensations.evaluation import noise_bias
from rigrunner_bearings.compensations.response import Waveform
from rigrunner_bearings.compensations.support_friction import make_friction
from rigrunner_bearings.compensations.swing import make_swing

SIZE, CYCLES, HERTZ = 256, 20, 1.0
STIFF = DriveLine(1e6, 0.5, 1e-3, 1.0, 0.0, LowPass(corner="1000 kHz"))
PHASE = 2 * np.pi * np.arange(SIZE) / SIZE
CURVE = 0.7 * np.cos(PHASE)
WHERE = Reversals(np.r_[224:256, 0:33], np.arange(96, 161))


def run(rng, noise_nm):
    cycles = CURVE + noise_nm * rng.standard_normal((CYCLES, SIZE))
    mean = cycles.mean(axis=0)
    return MeanSwing(HERTZ, mean, (mean - cycles) / (CYCLES - 1))


def simulated_errors(noise_nm, rounds=300):
    """Return the errors of the greatest value, and without the expected bias, shape (rounds,)."""
    rng = np.random.default_rng(3)
    errors = []
    for _ in range(rounds):
        loaded = run(rng, noise_nm)
        bearing = STIFF.at_load(loaded.waveform, HERTZ)
        greatest = float(WHERE.torque(bearing))
        bias = noise_bias(bearing, [replicates(STIFF, bearing, loaded, +1)], WHERE)
        errors.append((greatest - 0.7, greatest - bias - 0.7))
    return np.array(errors)


def test_noise_bias_of_maximum_is_corrected():
    greatest, corrected = simulated_errors(0.1).mean(axis=0)
    assert greatest > 0.008
    assert abs(corrected) < greatest - corrected  # the correction itself is uncertain


def test_without_noise_there_is_no_correction():
    assert simulated_errors(0.0, rounds=1)[0] == pytest.approx([0.0, 0.0], abs=1e-10)


def test_load_without_samples_after_reversal_is_refused():
    friction = SimpleNamespace(swing=make_swing(2 / 45, SIZE))
    loaded = run(np.random.default_rng(3), 0.0)
    assert len(reversals(STIFF, friction, loaded, 0.01).forward)
    with pytest.raises(DataError, match="at 1 Hz the load has no reversal to look behind"):
        reversals(STIFF, friction, loaded, 1e-12)


LINE = DriveLine(300.0, 0.05, 2e-3, 0.6, 2e-5, LowPass(corner="900 Hz"))
VARIED = [
    {},
    {"natural_hz": 310.0},
    {"damping_ratio": 0.06},
    {"inertia_kgm2": 3e-3},
    {"share": 0.0},
    {"share": 1.0},
    {"delay_s": 0.0},
    {"low_pass": LowPass(corner="990 Hz")},
    {"harmonics": 19},
]


def uncached_torque(line, friction, mean):
    hertz = mean.frequency_hz
    inertial = line.inertia_kgm2 * friction.swing.acceleration_per_hz2 * hertz**2
    twist = line.twist(Waveform(mean.torque_nm), hertz)
    at_load = line.at_load(Waveform(mean.torque_nm), hertz)
    return at_load - inertial - friction.torque(hertz, twist, line.share)


def test_cached_torque_equals_uncached_bit_for_bit():
    """Fails if the key of a cache lacks a quantity that the cached value depends on."""
    swing, rng = make_swing(2 / 45, SIZE), np.random.default_rng(5)
    steps = np.tanh(20 * swing.velocity_per_hz)
    frictions = [
        make_friction(swing, 1e-4 * rng.random() * steps, level * steps, 0.01 * steps, 12.0)
        for level in (0.7, 0.8)
    ]
    runs = [replace(run(rng, 0.01), frequency_hz=hertz) for hertz in (10.0, 10.0, 10.01)]
    for _ in range(2):
        for friction in frictions:
            for pair in (Pair(runs[0], runs[1]), Pair(runs[2], runs[1])):
                for change in VARIED:
                    line = replace(LINE, **change)
                    torque = bearing_torque(line, friction, pair)
                    expected = uncached_torque(line, friction, pair.loaded) - uncached_torque(
                        line, friction, pair.no_load
                    )
                    np.testing.assert_array_equal(torque, expected)
