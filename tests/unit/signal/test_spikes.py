import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from helpers_thorough import examples
from rigrunner.signal.spikes import hampel


def by_the_book(values, window, threshold):
    """Pearson 2002, sample by sample, with the floor that hampel's docstring states."""
    half = window // 2
    padded = np.pad(values, half, mode="edge")
    windows = [padded[i : i + 2 * half + 1] for i in range(len(values))]
    centre = np.array([np.median(window) for window in windows])
    local = [np.median(np.abs(w - c)) for w, c in zip(windows, centre, strict=True)]
    sigma = 1.4826022185 * np.maximum(local, np.median(np.abs(values - centre)))
    spikes = np.abs(values - centre) > threshold * sigma
    return np.where(spikes, centre, values), int(spikes.sum())


@given(st.integers(0, 2**32 - 1), st.sampled_from([3, 5, 11]), st.sampled_from([2.0, 3.5, 6.0]))
@settings(max_examples=examples(30), deadline=None)
def test_hampel_equals_the_definition(seed, window, threshold):
    rng = np.random.default_rng(seed)
    values = rng.standard_normal(200) + 5 * (rng.random(200) < 0.03)
    cleaned, count = hampel(values, window, threshold)
    expected, expected_count = by_the_book(values, window, threshold)
    assert count == expected_count
    np.testing.assert_allclose(cleaned, expected)


def ringing_torque(rng, noise=0.02, rate=10e3):
    """A torque channel at 35 Hz: friction that steps at reversals and rings at 400 Hz."""
    time = np.arange(30_000) / rate
    since = time % (1 / 70)
    side = np.where((time * 70).astype(int) % 2, 1.0, -1.0)
    ring = np.exp(-2 * np.pi * 20 * since) * np.cos(2 * np.pi * 400 * since)
    low_pass = signal.butter(2, 1000, fs=rate, output="sos")
    torque = signal.sosfilt(low_pass, side * (1 - 2 * ring) + 5 * np.sin(2 * np.pi * 35 * time))
    return torque + noise * rng.standard_normal(len(time))


def test_hampel_keeps_steps_and_ringing():
    clean = ringing_torque(np.random.default_rng(1))
    cleaned, count = hampel(clean, 11)
    assert count < 1e-4 * len(clean)
    assert np.sqrt(np.mean((cleaned - clean) ** 2)) < 0.001


def test_hampel_removes_and_counts_spikes():
    rng = np.random.default_rng(2)
    clean = np.sin(np.linspace(0, 60, 20_000)) + 0.02 * rng.standard_normal(20_000)
    where = rng.choice(20_000, 20, replace=False)
    spiked = clean.copy()
    spiked[where] += rng.choice([-1, 1], 20) * rng.uniform(0.5, 5, 20)
    cleaned, count = hampel(spiked, 11)
    assert count == 20
    assert np.abs(cleaned[where] - clean[where]).max() < 0.1
    untouched = np.setdiff1d(np.arange(20_000), where)
    np.testing.assert_array_equal(cleaned[untouched], spiked[untouched])


def test_hampel_does_not_change_its_input():
    values = np.zeros(50)
    values[25] = 9.0
    _, count = hampel(values, 5)
    assert count == 1
    assert values[25] == 9.0


def test_constant_record_has_no_spikes():
    assert hampel(np.full(100, 3.0), 11)[1] == 0


@pytest.mark.parametrize("window", [0, 1, 2])
def test_hampel_refuses_a_window_without_neighbours(window):
    with pytest.raises(ValueError, match="3 is the least"):
        hampel(np.zeros(10), window)
