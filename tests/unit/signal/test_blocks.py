"""What is computed of samples block by block is what is computed of all of them at once."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from helpers_long import BLOCK, short_blocks
from helpers_thorough import examples
from rigrunner.signal.blocks import Less, blocks, cycle_groups, groups, limits
from rigrunner.signal.crossings import rises
from rigrunner.signal.extremes import extremes
from rigrunner.signal.order import percentiles
from rigrunner.signal.spikes import despiked, hampel

RATIO = 2 / 45
RATE_HZ = 10e3


class Stored:
    """Samples that are there only by slices, none longer than a few blocks."""

    def __init__(self, values):
        self._values = values
        self.samples_read = 0
        """Samples in all slices so far."""

    def __len__(self):
        return len(self._values)

    def __getitem__(self, which):
        part = self._values[which].copy()
        assert len(part) <= 2 * BLOCK, "that much is too long for memory"
        self.samples_read += len(part)
        return part


def swing(samples=40_000, frequency_hz=10.3, noise=0.01):
    phase = 2 * np.pi * frequency_hz / RATE_HZ * np.arange(samples) + 0.3
    rng = np.random.default_rng(1)
    angle = np.arctan2(RATIO * np.sin(phase), 1 + RATIO * np.cos(phase))
    return angle + noise * RATIO * rng.standard_normal(samples) + 0.001


@given(period=st.floats(30, 9000), noise=st.sampled_from([0.01, 0.3]), block=st.integers(500, 7000))
@settings(max_examples=examples(30), suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_rises_go_on_over_the_ends_of_blocks(monkeypatch, period, noise, block):
    values = swing(20_000, RATE_HZ / period, noise)
    expected = rises(values, -0.01, 0.01)
    short_blocks(monkeypatch, block)
    assert [list(rise) for rise in rises(values, -0.01, 0.01)] == [list(pair) for pair in expected]


@given(block=st.integers(1, 60), edges=st.sets(st.integers(0, 200), min_size=2))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_extremes_are_those_of_parts_over_several_blocks(monkeypatch, block, edges):
    values, places = np.random.default_rng(1).standard_normal(200), np.array(sorted(edges))
    short_blocks(monkeypatch, block)
    parts = [values[a:b] for a, b in itertools.pairwise(places)]
    expected = [[part.min() for part in parts], [part.max() for part in parts]]
    assert [extreme.tolist() for extreme in extremes(values, places)] == expected


@given(seed=st.integers(0, 99), block=st.integers(20, 400))
@settings(
    max_examples=examples(10),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
def test_spikes_are_those_of_the_whole_recording(monkeypatch, seed, block):
    rng = np.random.default_rng(seed)
    values = np.sin(np.arange(1000) / 50) + 0.01 * rng.standard_normal(1000)
    values[rng.integers(0, 1000, 12)] += rng.choice([-1, 1], 12)
    cleaned, count = hampel(values, 11)
    short_blocks(monkeypatch, block)
    in_blocks, again = despiked(values, 11)
    assert again == count > 0
    assert np.asarray(in_blocks).tolist() == cleaned.tolist()
    assert in_blocks[block - 5 : block + 9].tolist() == cleaned[block - 5 : block + 9].tolist()


LOUD, QUIET = np.repeat([1.0, 0.01], 5 * BLOCK), np.repeat([0.01, 1.0], 5 * BLOCK)


@pytest.mark.parametrize(
    ("loudness", "walks"),
    [(1.0, 1), (LOUD, 4), (QUIET, 4)],
    ids=["steady", "loud at first", "quiet at first"],
)
def test_spikes_of_a_steady_recording_are_found_in_one_walk(monkeypatch, loudness, walks):
    rng = np.random.default_rng(1)
    values = loudness * rng.standard_normal(10 * BLOCK)
    values[rng.integers(0, len(values), 30)] += 20
    cleaned, count = hampel(values, 11)
    short_blocks(monkeypatch)
    stored = Stored(values)
    in_blocks, again = despiked(stored, 11)
    assert stored.samples_read < (walks + 0.1) * len(values)
    assert again == count >= 30
    assert np.concatenate([part for _, part in blocks(in_blocks)]).tolist() == cleaned.tolist()


def test_percentiles_are_found_in_one_walk_and_a_block(monkeypatch):
    angle = swing(10 * BLOCK)
    expected = np.percentile(angle, [2, 98]).tolist()
    short_blocks(monkeypatch)
    stored = Stored(angle)
    assert percentiles(stored, [2, 98]) == expected
    assert stored.samples_read < 12 * BLOCK


def test_what_is_taken_off_is_taken_off_each_slice(monkeypatch):
    short_blocks(monkeypatch, 10)
    values = np.arange(25.0)
    shown = Less(Stored(values), 2.0)
    assert np.concatenate([part for _, part in blocks(shown)]).tolist() == (values - 2).tolist()
    assert limits(shown) == (-2.0, 22.0)


@given(st.lists(st.floats(1, 30), min_size=1, max_size=50))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_groups_hold_each_cycle_once_and_no_more_than_a_block(monkeypatch, periods):
    short_blocks(monkeypatch, 20)
    starts = np.cumsum([0.0, *periods])
    slices = cycle_groups(starts)
    assert [k for part in slices for k in range(part.start, part.stop)] == [*range(len(periods))]
    lone = [part for part in slices if part.stop - part.start == 1]
    assert all(starts[part.stop] - starts[part.start] <= 20 for part in slices if part not in lone)
    assert [k for part in groups(starts) for k in range(part.start, part.stop)] == [
        *range(len(starts))
    ]
