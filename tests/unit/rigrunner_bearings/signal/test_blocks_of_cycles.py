"""Cycles and pulses found block by block equal those found in all samples at once."""

from __future__ import annotations

import numpy as np
import pytest

from helpers_long import short_cycles
from rigrunner_bearings.signal.cycles import find_cycles, resample
from rigrunner_bearings.signal.pulses import pulse_edges, repetition_frequency
from unit.signal.test_blocks import RATE_HZ, RATIO, Stored, swing


def test_cycles_equal_those_of_whole_recording(monkeypatch):
    angle = swing()
    in_memory = find_cycles(angle, RATE_HZ, RATIO)
    short_cycles(monkeypatch)
    in_blocks = find_cycles(Stored(angle), RATE_HZ, RATIO)
    np.testing.assert_allclose(in_blocks.starts, in_memory.starts, rtol=0, atol=1e-9)
    assert (in_blocks.offset_rad, in_blocks.ratio) == pytest.approx(
        (in_memory.offset_rad, in_memory.ratio), 1e-12
    )


@pytest.mark.parametrize("n", [256, 1024])
def test_resampled_cycles_equal_those_of_whole_recording(monkeypatch, n):
    values, starts = swing(), np.arange(3.3, 39_000, 970.87)
    in_memory = resample(values, starts, n)
    short_cycles(monkeypatch)
    np.testing.assert_allclose(resample(Stored(values), starts, n), in_memory, rtol=0, atol=1e-12)


def test_pulses_equal_those_of_whole_recording(monkeypatch):
    signal = (np.arange(40_000) % 970 < 20) + 0.0
    in_memory = pulse_edges(signal)
    short_cycles(monkeypatch)
    assert pulse_edges(Stored(signal)).tolist() == in_memory.tolist()


def test_repetition_frequency_of_long_torque(monkeypatch):
    torque = np.sin(2 * np.pi * 10.3 / RATE_HZ * np.arange(200_000) + 1) + 3
    short_cycles(monkeypatch)
    assert repetition_frequency(Stored(torque), RATE_HZ, 10.0) == pytest.approx(10.3, rel=1e-4)
