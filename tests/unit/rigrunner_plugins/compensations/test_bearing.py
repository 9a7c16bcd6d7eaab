"""The starting torque in a curve with noise on it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner.api.instruments import LowPass
from rigrunner_plugins.compensations.bearing import MeanSwing, Reversals, replicates, reversals
from rigrunner_plugins.compensations.drive_line import DriveLine
from rigrunner_plugins.compensations.noise_bias import noise_bias
from rigrunner_plugins.compensations.swing import make_swing

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
    errors = []
    for _ in range(rounds):
        loaded = run(rng, noise_nm)
        bearing = STIFF.at_load(loaded.torque_nm, HERTZ)
        greatest = float(WHERE.torque(bearing))
        bias = noise_bias(bearing, [replicates(STIFF, bearing, loaded, +1)], WHERE)
        errors.append((greatest - 0.7, greatest - bias - 0.7))
    return np.array(errors)


def test_the_greatest_value_of_a_noisy_curve_is_high_and_is_put_right():
    greatest, without = studied(0.1).mean(axis=0)
    assert greatest > 0.008
    assert abs(without) < greatest - without  # what is taken off stays in doubt


def test_without_noise_there_is_nothing_to_put_right():
    assert studied(0.0, rounds=1)[0] == pytest.approx([0.0, 0.0], abs=1e-10)


def test_a_load_without_samples_behind_a_reversal_is_refused():
    friction = SimpleNamespace(swing=make_swing(2 / 45, SIZE))
    loaded = run(np.random.default_rng(3), 0.0)
    assert len(reversals(STIFF, friction, loaded, 0.01).forward)
    with pytest.raises(DataError, match="at 1 Hz the load has no reversal to look behind"):
        reversals(STIFF, friction, loaded, 1e-12)
