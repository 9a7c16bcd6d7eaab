from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.signal import crossings
from rigrunner.signal.crossings import beyond, rises

RATIO = 2 / 45
LIMIT = 0.3 * RATIO


def plain(values, low, high):
    """Return the rises as one would tell them: sample by sample."""
    before, after, last = [], [], None
    for index, value in enumerate(values):
        if value <= low:
            last = index
        elif value >= high:
            if last is not None:
                before.append(last)
                after.append(index)
            last = None
    return before, after


def equal(values, low, high):
    pairs = rises(values, low, high)
    return [list(pair) for pair in pairs] == [*plain(values, low, high)]


def swing(samples, period, noise=0.0, phase=0.0, seed=1):
    turned = 2 * np.pi * np.arange(samples) / period + phase
    angle = np.arctan2(RATIO * np.sin(turned), 1 + RATIO * np.cos(turned))
    return angle + noise * RATIO * np.random.default_rng(seed).standard_normal(samples)


@given(st.lists(st.floats(-2, 2), max_size=200))
def test_any_few_samples_are_told_as_one_by_one(values):
    assert equal(np.array(values, float), -1.0, 1.0)


@given(
    period=st.floats(70, 40_000),
    noise=st.sampled_from([0.0, 0.002, 0.05, 0.3, 1.0]),
    phase=st.floats(0, 7),
    seed=st.integers(0, 99),
)
def test_a_noisy_swing_is_told_as_one_by_one(period, noise, phase, seed):
    assert equal(swing(30_000, period, noise, phase, seed), -LIMIT, LIMIT)


@given(
    period=st.floats(1500, 40_000),
    spikes=st.lists(st.tuples(st.integers(0, 59_999), st.sampled_from([-1.0, 0.0, 1.0]))),
    quiet=st.integers(0, 20_000),
)
def test_spikes_and_rest_are_told_as_one_by_one(period, spikes, quiet):
    values = swing(60_000, period, 0.01)
    values[:quiet] = 0.0
    for index, value in spikes:
        values[index] = value
    assert equal(values, -LIMIT, LIMIT)


@pytest.mark.parametrize("noise", [0.002, 0.02, 0.06])
def test_noise_makes_no_cycles_at_1_hz(noise):
    """60 s at 100 kS/s: as many swings as there were, where changes of sign show hundreds."""
    values = swing(1_000_000, 100_000, noise, phase=-1.5)
    before, after = rises(values, -LIMIT, LIMIT)
    assert len(before) == len(after) == 10
    assert np.count_nonzero((values[1:] > 0) & (values[:-1] <= 0)) > 40


@pytest.mark.parametrize(("period", "noise"), [(100_000, 0.02), (10_000, 0.01), (2857.1, 0.002)])
def test_few_samples_of_a_usual_recording_are_looked_at_one_by_one(monkeypatch, period, noise):
    """Counted in samples of the slow way, not in time."""
    seen, slow = [], crossings._turns
    monkeypatch.setattr(
        crossings, "_turns", lambda low, high: seen.append(len(low)) or slow(low, high)
    )
    values = swing(600_000, period, noise)
    assert equal(values, -LIMIT, LIMIT)
    assert sum(seen) < 0.1 * len(values)


@given(st.floats(-1e3, 1e3), st.floats(1e-6, 1e3))
def test_the_levels_are_the_last_that_floating_point_tells_apart(middle, limit):
    low, high = beyond(middle, limit)
    assert low - middle < -limit
    assert not np.nextafter(low, np.inf) - middle < -limit
    assert high - middle > limit
    assert not np.nextafter(high, -np.inf) - middle > limit
