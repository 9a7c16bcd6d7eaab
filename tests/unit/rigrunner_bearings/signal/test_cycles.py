import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers_thorough import examples
from rigrunner.api.errors import DataError
from rigrunner_bearings.signal.cycles import find_cycles, resample

RATIO = 2 / 45
DEG = np.pi / 180
RATE = 10e3


def swing(phase):
    """The oscillating guide bar (Wang et al., Machines 2025, 13(11), 976)."""
    return np.arctan2(RATIO * np.sin(phase), 1 + RATIO * np.cos(phase))


def encoder(angle, rng, offset=0.0):
    noisy = angle + offset + 0.003 * DEG * rng.standard_normal(len(angle))
    return 0.01 * DEG * np.round(noisy / (0.01 * DEG))


def recorded(frequency, cycles, start_rad, jitter=0.0, seed=0):
    """Return the crank phase of each sample, with a speed that differs from cycle to cycle."""
    rng = np.random.default_rng(seed)
    samples = int(cycles / frequency * RATE)
    count = int(cycles) + 4
    lengths = 1 / frequency / (1 + jitter * rng.standard_normal(count))
    turns = np.interp(
        np.arange(samples) / RATE, np.concatenate([[0], np.cumsum(lengths)]), np.arange(count + 1)
    )
    return start_rad + 2 * np.pi * turns


def true_starts(phase):
    turns = 2 * np.pi * np.arange(np.ceil(phase[0] / 2 / np.pi), phase[-1] / 2 / np.pi)
    return np.interp(turns, phase, np.arange(len(phase)))


@given(
    frequency=st.floats(1, 40),
    start=st.floats(0.2, 6.0),
    offset=st.floats(-0.2 * DEG, 0.2 * DEG),
)
@settings(max_examples=examples(25), deadline=None)
def test_finds_start_of_every_whole_cycle(frequency, start, offset):
    phase = recorded(frequency, 8, start)
    angle = encoder(swing(phase), np.random.default_rng(3), offset)
    cycles = find_cycles(angle, RATE, RATIO)
    expected = true_starts(phase)
    assert cycles.count == len(expected) - 1
    error_rad = (cycles.starts - expected) * frequency / RATE * 2 * np.pi
    assert np.abs(error_rad).max() < 1e-3
    assert abs(error_rad.mean()) < 2e-4
    assert cycles.frequency_hz.mean() == pytest.approx(frequency, rel=2e-4)
    assert cycles.offset_rad == pytest.approx(offset, abs=0.0005 * DEG)
    assert cycles.ratio == pytest.approx(RATIO, rel=2e-3)


def test_one_whole_cycle_is_enough():
    phase = recorded(10.0, 1.3, 5.5)
    cycles = find_cycles(encoder(swing(phase), np.random.default_rng(3)), RATE, RATIO)
    assert cycles.count == 1
    assert cycles.frequency_hz[0] == pytest.approx(10.0, rel=1e-3)


def test_encoder_noise_gives_no_extra_cycles():
    phase = recorded(1.0, 60.5, 0.3)
    angle = encoder(swing(phase), np.random.default_rng(4))
    naive = np.count_nonzero((angle[:-1] <= 0) & (angle[1:] > 0))
    assert naive > 60, "a naive count finds too many"
    assert find_cycles(angle, RATE, RATIO).count == 59


def test_frequency_follows_variation_between_cycles():
    phase = recorded(10.0, 31, 2.0, jitter=5e-4, seed=5)
    cycles = find_cycles(encoder(swing(phase), np.random.default_rng(6)), RATE, RATIO)
    true = RATE / np.diff(true_starts(phase))
    assert cycles.frequency_hz == pytest.approx(true, abs=0.002)
    assert cycles.frequency_hz.std() == pytest.approx(true.std(), rel=0.3)


@pytest.mark.parametrize(
    "angle",
    [
        np.zeros(5000),
        swing(np.linspace(0.3, 3.0, 5000)),
        0.003 * DEG * np.random.default_rng(7).standard_normal(50_000),
    ],
    ids=["at rest", "less than a cycle", "noise"],
)
def test_recording_without_cycle_is_refused(angle):
    with pytest.raises(DataError, match=r"no whole cycle of about 2\.5 deg"):
        find_cycles(angle, RATE, RATIO)


@pytest.mark.parametrize(("hz", "within"), [(35.0, 1e-6), (800.0, 1e-4), (1200.0, 1e-3)])
def test_resampling_keeps_harmonics_of_fast_swing(hz, within):
    time = np.arange(4000) / RATE
    starts = 100.3 + np.arange(11) * RATE / 35.0
    rows = resample(np.cos(2 * np.pi * hz * time), starts)
    times = (starts[:-1, None] + np.diff(starts)[:, None] * np.arange(1024) / 1024) / RATE
    assert rows.shape == (10, 1024)
    np.testing.assert_allclose(rows, np.cos(2 * np.pi * hz * times), atol=within)


def test_resampling_aligns_cycles_of_different_length():
    phase = recorded(7.3, 12, 1.0, jitter=0.002, seed=8)
    rows = resample(swing(phase), true_starts(phase))
    spread = np.ptp(rows, axis=0).max()
    assert spread < 0.01 * RATIO
    np.testing.assert_allclose(
        rows.mean(axis=0), swing(2 * np.pi * np.arange(1024) / 1024), atol=0.005 * RATIO
    )


def test_downsampling_averages_noise_without_aliasing():
    rng = np.random.default_rng(9)
    starts = 50.0 + 10_000 * np.arange(9)
    rows = resample(rng.standard_normal(90_000), starts)
    assert rows.var() == pytest.approx(1024 / 10_000, rel=0.1)
    assert rows.mean(axis=1) == pytest.approx(np.zeros(8), abs=0.05)


def test_downsampling_keeps_level_and_phase():
    time = np.arange(60_000) / RATE
    starts = 123.4 + 10_000 * np.arange(5)
    rows = resample(2 + np.sin(2 * np.pi * 20 * (time - 0.01234)), starts)
    expected = 2 + np.sin(2 * np.pi * 20 * np.arange(1024) / 1024)
    np.testing.assert_allclose(rows[1], expected, atol=1e-3)


def test_refuses_spikes_that_shorten_cycles():
    rng = np.random.default_rng(4)
    angle = swing(recorded(10.0, 20, 1.0))
    places = rng.choice(len(angle), 400, replace=False)
    angle[places] += 4.0 * DEG * rng.choice([-1.0, 1.0], len(places))
    with pytest.raises(DataError, match=r"a cycle at .* s is shorter than half of the others"):
        find_cycles(angle, RATE, RATIO)
