"""The starting torque in a curve with noise on it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.api.instruments import LowPass
from rigrunner_plugins.compensations.bearing import MeanSwing, Pair, Reversals, peak_bias
from rigrunner_plugins.compensations.drive_line import DriveLine

SIZE, CYCLES, HERTZ = 256, 20, 1.0
STIFF = DriveLine(1e6, 0.5, 1e-3, 1.0, 0.0, LowPass(corner="1000 kHz"))
PHASE = 2 * np.pi * np.arange(SIZE) / SIZE
CURVE = 0.7 * np.cos(PHASE)
WHERE = Reversals(np.r_[224:256, 0:33], np.arange(96, 161))


def run(rng, noise_nm):
    cycles = CURVE + noise_nm * rng.standard_normal((CYCLES, SIZE))
    without_each = (cycles.sum(axis=0) - cycles) / (CYCLES - 1)
    return MeanSwing(HERTZ, cycles.mean(axis=0), without_each)


def studied(noise_nm, rounds=300):
    """Return the errors of the greatest value, and without the expected bias, shape (rounds,)."""
    rng = np.random.default_rng(3)
    nothing = MeanSwing(HERTZ, 0 * CURVE, np.zeros((CYCLES, SIZE)))
    errors = []
    for _ in range(rounds):
        loaded = run(rng, noise_nm)
        bearing = STIFF.at_load(loaded.torque_nm, HERTZ)
        greatest = float(WHERE.torque(bearing))
        bias = peak_bias(STIFF, WHERE, bearing, Pair(loaded, nothing))
        errors.append((greatest - 0.7, greatest - bias - 0.7))
    return np.array(errors)


def test_the_greatest_value_of_a_noisy_curve_is_high_and_is_put_right():
    greatest, without = studied(0.1).mean(axis=0)
    assert greatest > 0.008
    assert abs(without) < greatest / 3


def test_without_noise_there_is_nothing_to_put_right():
    assert studied(0.0, rounds=1)[0] == pytest.approx([0.0, 0.0], abs=1e-10)


def test_a_template_without_cycles_has_no_bias_of_them():
    rng = np.random.default_rng(4)
    biases = []
    for _ in range(100):
        loaded, no_load = run(rng, 0.1), run(rng, 0.1)
        bearing = STIFF.at_load(loaded.torque_nm - no_load.torque_nm + CURVE, HERTZ)
        templates = no_load, replace(no_load, of_cycles=False)
        pairs = [Pair(loaded, template) for template in templates]
        biases.append([peak_bias(STIFF, WHERE, bearing, pair) for pair in pairs])
    both, one = np.mean(biases, axis=0)
    assert both == pytest.approx(2 * one, rel=0.3)
    assert one > 0.001
