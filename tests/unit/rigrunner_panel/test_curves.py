"""Curves for the screen: what is shown is what was recorded, and no more is kept than is shown."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from e2e.helpers_panel import parse_frame
from rigrunner.api.data import Block
from rigrunner.api.events import Samples
from rigrunner_panel.live.curves import Curves, frame
from rigrunner_panel.live.swing import PHASES, SwingCutter
from rigrunner_panel.live.trend import COLUMNS, STEP_S, Trend

RATE_HZ = 2000.0


def swinging(seconds, frequency_hz=5.0, start_s=0.0):
    """Return angle and torque with a peak of 2 at phase 90 degrees and an offset of 0.5."""
    t = start_s + np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    phase = 2 * np.pi * frequency_hz * t + 1.0
    return (0.04 * np.sin(phase)).astype(np.float32), (0.5 + 1.5 * np.sin(phase)).astype(np.float32)


def blocks(*arrays, size=200):
    for first in range(0, len(arrays[0]), size):
        yield tuple(each[first : first + size] for each in arrays)


def test_swings_are_cut_once_each_and_begin_where_the_angle_rises():
    angle, torque = swinging(3.0)
    angle = angle + np.random.default_rng(1).normal(0, 4e-4, len(angle)).astype(np.float32)
    cutter = SwingCutter(RATE_HZ, 5.0)
    swings = [one for a, t in blocks(angle, torque) for one in cutter.take(t, a)]
    ends = [one.end_s for one in swings]
    assert len(swings) == 14  # of 15 periods the first one has begun before the recording
    assert np.diff(ends) == pytest.approx(0.2, abs=3e-3)
    for one in swings:
        assert one.frequency_hz == pytest.approx(5.0, rel=0.02)
        assert one.raw_nm[PHASES // 4] == pytest.approx(2.0, abs=0.01)
        assert one.raw_nm[3 * PHASES // 4] == pytest.approx(-1.0, abs=0.01)


def test_noise_of_a_rig_at_rest_is_no_swing():
    noise = np.random.default_rng(2).normal(0, 1e-3, 20_000).astype(np.float32)
    cutter = SwingCutter(RATE_HZ, 5.0)
    assert not [one for a, t in blocks(noise, noise) for one in cutter.take(t, a)]


def test_without_an_angle_the_set_frequency_tells_how_long_a_swing_is():
    _, torque = swinging(2.0)
    cutter = SwingCutter(RATE_HZ, 5.0)
    swings = [one for (t,) in blocks(torque) for one in cutter.take(t, None)]
    assert len(swings) == 9
    assert {one.angle_rad for one in swings} == {None}


def test_a_cutter_keeps_little_of_what_it_was_given():
    cutter = SwingCutter(RATE_HZ, 5.0)
    for number in range(200):
        angle, torque = swinging(0.1, start_s=number * 0.1)
        cutter.take(torque, angle)
    assert len(cutter._torque) < RATE_HZ
    still = SwingCutter(RATE_HZ, 0.001)
    for _ in range(1000):
        still.take(np.zeros(2000, np.float32), np.zeros(2000, np.float32))
    assert len(still._torque) <= 31 * RATE_HZ


@given(
    st.lists(st.integers(1, 700), min_size=1, max_size=20),
    st.floats(0, 30),
    st.sampled_from([100.0, 2000.0, 10_000.0]),
)
def test_a_column_has_the_extremes_of_its_samples_however_they_come(sizes, start_s, rate_hz):
    values = np.random.default_rng(3).normal(size=sum(sizes)).astype(np.float32)
    trend, first = Trend(), 0
    for size in sizes:
        trend.take(start_s + first / rate_hz, rate_hz, values[first : first + size])
        first += size
    low_at, low, high = trend.since(0)
    # independently: each sample on its own, at the time that its block gives it
    expected: dict[int, list[float]] = {}
    first = 0
    for size in sizes:
        block_s = start_s + first / rate_hz
        for i in range(size):
            column = int((block_s + i / rate_hz) / STEP_S)
            expected.setdefault(column, []).append(float(values[first + i]))
        first += size
    for column, found in expected.items():
        if column >= low_at:
            assert low[column - low_at] == np.float32(min(found))
            assert high[column - low_at] == np.float32(max(found))
    assert len(low) <= COLUMNS


def test_a_trend_of_hours_is_no_longer_than_its_window_and_shows_gaps():
    trend = Trend()
    trend.take(0.0, 100.0, np.ones(100, np.float32))
    trend.take(8 * 3600.0, 100.0, np.full(100, 2.0, np.float32))
    first, low, high = trend.since(0)
    assert (len(low), len(high)) == (COLUMNS, COLUMNS)
    assert first == round(8 * 3600 / STEP_S) + 20 - COLUMNS
    assert np.isnan(low[:-20]).all()
    assert (low[-20:] == 2).all()


def test_samples_that_come_too_late_for_the_window_are_left_out():
    trend = Trend()
    trend.take(3600.0, 100.0, np.ones(10, np.float32))
    trend.take(0.0, 100.0, np.full(10, 9.0, np.float32))
    assert np.nanmax(trend.since(0)[2]) == 1.0


@given(st.lists(st.floats(width=32, allow_nan=False), max_size=50), st.text(max_size=30))
def test_a_frame_says_what_was_put_in_aligned_to_four_bytes(values, text):
    content = frame({"kind": text}, {"a": np.array(values, np.float32), "b": np.ones(3)})
    header, arrays = parse_frame(content)
    assert header["kind"] == text
    assert header["arrays"] == [["a", len(values)], ["b", 3]]
    assert arrays["a"].tolist() == np.array(values, np.float32).tolist()
    assert int.from_bytes(content[:4], "little") % 4 == 0


def curve(start, angle, torque, recording="001"):
    channels = {"tester.angle": angle, "tester.torque": torque}
    return samples(recording, Block(RATE_HZ, start, 0.0, channels))


def samples(recording, block, monotonic_s=0.0):
    return Samples(seq=0, monotonic_s=monotonic_s, utc="2026", recording=recording, block=block)


def test_swings_of_one_block_are_shown_one_after_the_other_and_compensated_when_known():
    curves = Curves()
    curves.begin("001", 5.0)
    angle, torque = swinging(1.0)
    curves.take(curve(0, angle, torque), 0.0)
    frames = [parse_frame(one) for one in iter(curves.next_swing, None)]
    assert len(frames) == 4
    assert [list(arrays) for _, arrays in frames] == [["raw_nm", "angle_rad"]] * 4
    correction = 1.5 * np.sin(2 * np.pi * np.arange(512) / 512)
    curves.correct("001", correction)
    angle, torque = swinging(1.0, start_s=1.0)
    curves.take(curve(2000, angle, torque), 1.0)
    _, arrays = parse_frame(curves.next_swing())
    assert arrays["compensated_nm"] == pytest.approx(0.5, abs=0.01)


def test_another_recording_is_not_compensated_with_this_ones_correction():
    curves = Curves()
    curves.correct("001", np.ones(16))
    curves.begin("002", 5.0)
    angle, torque = swinging(1.0)
    curves.take(curve(0, angle, torque, "002"), 0.0)
    assert "compensated_nm" not in parse_frame(curves.next_swing())[1]


def test_the_trend_tells_only_what_is_new_and_a_new_screen_everything():
    curves = Curves()
    angle, torque = swinging(2.0)
    curves.take(curve(0, angle[:2000], torque[:2000]), 0.0)
    assert parse_frame(curves.next_trend())[0]["first"] == 0
    assert curves.next_trend() is None
    curves.take(curve(2000, angle[2000:], torque[2000:]), 1.0)
    header, arrays = parse_frame(curves.next_trend())
    assert (header["first"], header["reset"], len(arrays["min_nm"])) == (20, False, 20)
    header, arrays = parse_frame(curves.whole()[0])
    assert (header["first"], header["reset"], len(arrays["min_nm"])) == (0, True, 40)


def test_without_a_torque_the_first_channel_is_over_time_and_is_named():
    curves = Curves()
    air = np.linspace(290, 300, 200, dtype=np.float32)
    curves.begin("001", None)
    block = Block(RATE_HZ, 0, 0.1, {"chamber.air": air, "meter.resistance": 2 * air})
    curves.take(samples("001", block), 0)
    header, arrays = parse_frame(curves.next_trend())
    assert header["channel"] == "chamber.air"
    assert (arrays["min_nm"].min(), arrays["max_nm"].max()) == (290, 300)
    assert curves.next_swing() is None
