"""Whole swings are cut from samples as they arrive, and at most one swing is kept."""

from __future__ import annotations

import numpy as np
import pytest

from rigrunner_bearings.signal.swing_cutter import PHASES, SwingCutter

RATE_HZ = 2000.0


def swinging(seconds, frequency_hz=5.0, start_s=0.0):
    """Return angle and torque with a peak of 2 at phase 90 degrees and an offset of 0.5."""
    t = start_s + np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    phase = 2 * np.pi * frequency_hz * t + 1.0
    return (0.04 * np.sin(phase)), (0.5 + 1.5 * np.sin(phase))


def blocks(*arrays, size=200):
    for first in range(0, len(arrays[0]), size):
        yield tuple(array[first : first + size] for array in arrays)


def test_each_swing_is_cut_once_where_angle_rises():
    angle, torque = swinging(3.0)
    angle = angle + np.random.default_rng(1).normal(0, 4e-4, len(angle))
    cutter = SwingCutter(RATE_HZ, 5.0)
    swings = [swing for a, t in blocks(angle, torque) for swing in cutter.take(t, a)]
    ends = [swing.end_s for swing in swings]
    assert len(swings) == 14  # of 15 periods the first one has begun before the recording
    assert np.diff(ends) == pytest.approx(0.2, abs=3e-3)
    for swing in swings:
        assert swing.frequency_hz == pytest.approx(5.0, rel=0.02)
        assert swing.torque_nm[PHASES // 4] == pytest.approx(2.0, abs=0.01)
        assert swing.torque_nm[3 * PHASES // 4] == pytest.approx(-1.0, abs=0.01)


def test_noise_of_rig_at_rest_is_no_swing():
    noise = np.random.default_rng(2).normal(0, 1e-3, 20_000)
    cutter = SwingCutter(RATE_HZ, 5.0)
    assert not [swing for a, t in blocks(noise, noise) for swing in cutter.take(t, a)]


def test_set_frequency_gives_swing_length_without_angle():
    _, torque = swinging(2.0)
    cutter = SwingCutter(RATE_HZ, 5.0)
    swings = [swing for (t,) in blocks(torque) for swing in cutter.take(t, None)]
    assert len(swings) == 9


def test_cutter_keeps_few_samples():
    cutter = SwingCutter(RATE_HZ, 5.0)
    for number in range(200):
        angle, torque = swinging(0.1, start_s=number * 0.1)
        cutter.take(torque, angle)
    assert len(cutter._torque) < RATE_HZ
    still = SwingCutter(RATE_HZ, 0.001)
    for _ in range(1000):
        still.take(np.zeros(2000), np.zeros(2000))
    assert len(still._torque) <= 31 * RATE_HZ


def test_time_after_gap_is_that_of_recording():
    angle, torque = swinging(1.0)
    cutter = SwingCutter(RATE_HZ, 5.0, 10_000)
    swings = [swing for a, t in blocks(angle, torque) for swing in cutter.take(t, a)]
    assert 5.0 < swings[0].end_s < 5.45
