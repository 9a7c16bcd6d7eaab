from __future__ import annotations

import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner_bearings.signal.pulses import (
    pulse_edges,
    repetition_frequency,
    starts_by_frequency,
    starts_from_edges,
)

RATE_HZ = 1000.0


def pulses(edges, samples, width=5.0, low=0.0, high=1.0):
    """Return a signal that is high for `width` samples from each (fractional) edge on."""
    time = np.arange(samples)
    signal = np.full(samples, low)
    for edge in edges:
        signal[(time >= edge) & (time < edge + width)] = high
    return signal


def test_edge_is_found_to_half_a_sample():
    edges = np.array([10.3, 110.7, 211.0, 311.4])
    assert pulse_edges(pulses(edges, 400)) == pytest.approx(edges, abs=0.5)


@pytest.mark.parametrize(("low", "high"), [(0.0, 5.0), (-12.0, 12.0), (0.4, 3.3)])
def test_signal_level_does_not_matter(low, high):
    edges = np.array([10.3, 110.7, 211.0])
    noise = 0.05 * (high - low) * np.random.default_rng(1).standard_normal(300)
    signal = pulses(edges, 300, low=low, high=high) + noise
    assert pulse_edges(signal) == pytest.approx(edges, abs=0.5)


def test_pulse_high_from_start_is_not_an_edge():
    assert pulse_edges(pulses([-2.0, 98.5, 198.5], 250)) == pytest.approx([98.5, 198.5], abs=0.5)


def test_slow_rise_is_one_edge():
    ramp = np.interp(np.arange(300), [98, 104, 110, 112, 198, 204, 210, 212], [0, 0.6, 1, 0] * 2)
    ramp[:98] = 0
    assert len(pulse_edges(ramp)) == 2


@pytest.mark.parametrize("signal", [np.zeros(100), np.ones(100), pulses([50.0], 100)])
def test_fewer_than_two_pulses_are_refused(signal):
    with pytest.raises(DataError, match=r"^[01] pulses, but a cycle is from one to the next"):
        pulse_edges(signal)


def test_lost_pulse_is_refused_with_its_place():
    edges = np.delete(np.arange(20.0, 1000.0, 100.0), 4)
    with pytest.raises(DataError, match="from pulse 4 to the next are 200 samples, usual are 100"):
        pulse_edges(pulses(edges, 1000))


def test_doubled_pulse_is_refused():
    edges = np.sort(np.append(np.arange(20.0, 1000.0, 100.0), 350.0))
    with pytest.raises(DataError, match="one was lost or came twice"):
        pulse_edges(pulses(edges, 1000))


def test_starts_precede_pulse_by_its_phase():
    edges = np.array([120.0, 220.0, 320.0])
    assert starts_from_edges(edges, np.pi / 2, 400) == pytest.approx([95, 195, 295])
    assert starts_from_edges(edges, -np.pi / 2, 400) == pytest.approx([145, 245, 345])


def test_starts_outside_recording_are_omitted():
    assert starts_from_edges(np.array([20.0, 120.0]), np.pi, 200) == pytest.approx([70.0])
    assert starts_from_edges(np.array([20.0, 120.0]), -np.pi, 150) == pytest.approx([70.0])


def bump(time_s, frequency_hz, phase):
    """Return a narrow peak once a cycle, in cycles from `phase` of a turn on."""
    return np.exp(8 * (np.cos(2 * np.pi * (frequency_hz * time_s - phase)) - 1))


@pytest.mark.parametrize("phase", np.arange(0, 1, 0.13))
def test_cut_by_frequency_avoids_the_peak(phase):
    time = np.arange(5000) / RATE_HZ
    starts = starts_by_frequency(bump(time, 7.0, phase), RATE_HZ, 7.0)
    assert np.diff(starts) == pytest.approx(RATE_HZ / 7.0)
    away = (starts / RATE_HZ * 7.0 - phase) % 1
    assert np.abs(away - 0.5).max() < 0.1
    assert len(starts) in {35, 36}


def test_less_than_one_cycle_is_refused():
    with pytest.raises(DataError, match=r"no whole cycle of 2 Hz in 0\.4 s"):
        starts_by_frequency(np.ones(400), RATE_HZ, 2.0)


@pytest.mark.parametrize("deviation", [-0.12, -0.006, 0.0, 0.004, 0.05, 0.14])
def test_repetition_is_found_despite_wrong_entry(deviation):
    rng = np.random.default_rng(2)
    time = np.arange(6000) / RATE_HZ
    true_hz = 5.0 * (1 + deviation)
    phase = 2 * np.pi * true_hz * time
    # A friction torque: a square wave in presliding, on a sine of inertia, with noise.
    torque = np.tanh(4 * np.cos(phase)) - 0.5 * np.sin(phase) + 0.05 * rng.standard_normal(6000)
    assert repetition_frequency(torque, RATE_HZ, 5.0) == pytest.approx(true_hz, rel=2e-4)
