"""Windows of a recording that goes on: whole cycles, each in one of them, and bounded."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigrunner.api.data import Block
from rigrunner.api.errors import DataError
from rigrunner_bearings.torque import live
from rigrunner_bearings.torque.live import Windows
from rigrunner_bearings.torque.motion import find_motion
from rigrunner_bearings.torque.prepare import prepare_point
from unit.analysis.helpers_analysis import recording, run_of, spec

PEAKS = 2 + 0.01 * np.arange(60)


def blocks_of(whole, size, start=0):
    for first in range(start, whole.samples, size):
        channels = {name: each[first : first + size] for name, each in whole.channels.items()}
        yield Block(whole.rate_hz, first, 0.0, channels)


def windows_of(whole, size, blocks=None):
    empty = replace(whole, channels=dict.fromkeys(whole.channels, np.empty(0)))
    cutter = Windows(empty, run_of(whole))
    return [each for block in blocks or blocks_of(whole, size) for each in cutter.take(block)]


def peaks_in(windows, run):
    points = [prepare_point(each, run, spec(), lambda _: []) for each in windows]
    return np.concatenate([each.peak_nm for each in points])


@settings(max_examples=25, deadline=None)
@given(
    frequency_hz=st.sampled_from([1.0, 7.3, 10.0, 34.0]),
    entered=st.floats(0.9, 1.1),
    lead=st.floats(0.01, 0.99),
    size=st.integers(50, 3000),
)
def test_each_cycle_is_in_one_window_and_has_the_value_of_the_whole_recording(
    frequency_hz, entered, lead, size
):
    whole = recording(PEAKS, frequency_hz, lead=lead)
    whole = replace(
        whole, setpoints={**whole.setpoints, "tester.frequency": entered * frequency_hz}
    )
    run = run_of(whole)
    windows = windows_of(whole, size)
    found = peaks_in(windows, run)
    wanted = prepare_point(whole, run, spec(), lambda _: []).peak_nm
    first = int(np.argmin(np.abs(wanted - found[0])))  # the very first may lie too near the border
    assert first <= 1
    assert np.array_equal(found, wanted[first : first + len(found)])
    longest = max(live.WINDOW_CYCLES, live.LEAST_S * frequency_hz) + 3
    assert len(wanted) - first - len(found) <= longest * 1.25 + size * frequency_hz / whole.rate_hz
    assert all(find_motion(each, run, each.channels["tester.torque"]) for each in windows)


def test_no_more_is_kept_than_a_window():
    whole = recording(np.tile(PEAKS, 5), 10.0)
    empty = replace(whole, channels=dict.fromkeys(whole.channels, np.empty(0)))
    cutter, kept = Windows(empty, run_of(whole)), []
    for block in blocks_of(whole, 100):
        list(cutter.take(block))
        kept.append(sum(len(each) for parts in cutter._channels.values() for each in parts))
    period = whole.rate_hz / 10.0
    cycles = max(live.WINDOW_CYCLES, live.LEAST_S * 10.0)
    assert max(kept) <= 2 * (cycles + 2 + 1) * period  # of two channels
    assert max(kept[len(kept) // 2 :]) == max(kept[: len(kept) // 2])


def test_a_slow_swing_has_windows_too():
    whole = recording(PEAKS[:20], 0.5)
    found = peaks_in(windows_of(whole, 1000), run_of(whole))
    wanted = prepare_point(whole, run_of(whole), spec(), lambda _: []).peak_nm
    assert len(found) >= live.WINDOW_CYCLES
    assert np.array_equal(found, wanted[: len(found)])


def test_after_a_gap_it_begins_anew():
    whole = recording(PEAKS, 10.0)
    half = whole.samples // 2 // 100 * 100
    lost = [each for each in blocks_of(whole, 100) if each.first_sample != half]
    found = peaks_in(windows_of(whole, 100, lost), run_of(whole))
    wanted = prepare_point(whole, run_of(whole), spec(), lambda _: []).peak_nm
    places = np.argmin(np.abs(wanted[None] - found[:, None]), axis=1)
    assert np.array_equal(found, wanted[places])
    assert (np.diff(places) > 0).all()
    assert half * 10.0 / whole.rate_hz not in places


def test_what_never_swings_is_told_and_does_not_pile_up(monkeypatch):
    monkeypatch.setattr(live, "MOST_SAMPLES", 5000)
    whole = recording(PEAKS, 10.0)
    still = replace(whole, channels={name: 0 * each for name, each in whole.channels.items()})
    empty = replace(still, channels=dict.fromkeys(still.channels, np.empty(0)))
    cutter = Windows(empty, run_of(still))
    for number, block in enumerate(blocks_of(still, 100), 1):
        too_few = pytest.raises(DataError, match="too few cycles in 5000 samples")
        with too_few if number % 51 == 0 else nullcontext():
            assert not list(cutter.take(block))
        assert cutter._samples <= 5000


def test_a_recording_at_rest_has_no_windows():
    whole = recording(PEAKS, 10.0)
    rest = replace(whole, setpoints={**whole.setpoints, "tester.frequency": 0.0})
    with pytest.raises(DataError, match="its frequency was set to zero"):
        windows_of(rest, 100)
