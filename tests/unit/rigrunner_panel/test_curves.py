"""Curves and trends for the screen: correct values in bounded memory."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from e2e.helpers_panel import parse_frame
from rigrunner.api.data import Block
from rigrunner.api.events import Samples
from rigrunner.api.figures import Axis, Curve
from rigrunner_panel.live.curves import Curves, frame
from rigrunner_panel.live.trend import COLUMNS, STEP_S, Trend

RATE_HZ = 2000.0


@given(
    st.lists(st.integers(1, 700), min_size=1, max_size=20),
    st.floats(0, 30),
    st.sampled_from([100.0, 2000.0, 10_000.0]),
)
def test_trend_column_has_the_extremes_of_its_samples(sizes, start_s, rate_hz):
    values = np.random.default_rng(3).normal(size=sum(sizes)).astype(np.float32)
    trend, first = Trend(), 0
    for size in sizes:
        trend.take(start_s + first / rate_hz, rate_hz, values[first : first + size])
        first += size
    low_at, low, high = trend.since(0)
    # independently: each sample alone, at the time given by its block
    expected: dict[int, list[float]] = {}
    first = 0
    for size in sizes:
        block_s = start_s + first / rate_hz
        for i in range(size):
            column = int((block_s + i / rate_hz) / STEP_S)
            expected.setdefault(column, []).append(float(values[first + i]))
        first += size
    for column, samples_in in expected.items():
        if column >= low_at:
            assert low[column - low_at] == np.float32(min(samples_in))
            assert high[column - low_at] == np.float32(max(samples_in))
    assert len(low) <= COLUMNS


def test_long_trend_is_limited_to_its_window_and_shows_gaps():
    trend = Trend()
    trend.take(0.0, 100.0, np.ones(100, np.float32))
    trend.take(8 * 3600.0, 100.0, np.full(100, 2.0, np.float32))
    first, low, high = trend.since(0)
    assert (len(low), len(high)) == (COLUMNS, COLUMNS)
    assert first == round(8 * 3600 / STEP_S) + 20 - COLUMNS
    assert np.isnan(low[:-20]).all()
    assert (low[-20:] == 2).all()


def test_samples_older_than_the_window_are_dropped():
    trend = Trend()
    trend.take(3600.0, 100.0, np.ones(10, np.float32))
    trend.take(0.0, 100.0, np.full(10, 9.0, np.float32))
    assert np.nanmax(trend.since(0)[2]) == 1.0


@given(st.lists(st.floats(width=32, allow_nan=False), max_size=50), st.text(max_size=30))
def test_frame_preserves_its_content_aligned_to_four_bytes(values, text):
    content = frame({"kind": text}, {"a": np.array(values, np.float32), "b": np.ones(3)})
    header, arrays = parse_frame(content)
    assert header["kind"] == text
    assert header["arrays"] == [["a", len(values)], ["b", 3]]
    assert arrays["a"].tolist() == np.array(values, np.float32).tolist()
    assert int.from_bytes(content[:4], "little") % 4 == 0


CURVE = Curve(
    title="One cycle", x=Axis("phase", "°", 0.0, 360.0), y=Axis("force", "N"),
    at=np.array([0.0, 180.0, 360.0]), end_s=2.0, frequency_hz=5.0,
    series={"measured": np.array([1.0, 2.0, 1.0]), "corrected": np.array([0.5, 1.5, 0.5])},
)  # fmt: skip


def samples(recording, block, monotonic_s=0.0):
    return Samples(seq=0, monotonic_s=monotonic_s, utc="2026", recording=recording, block=block)


def block_of(values, first=0, name="chamber.air"):
    return Block(RATE_HZ, first, 0.0, {name: np.asarray(values, np.float32)})


def test_curve_is_sent_with_its_axes_and_end_time():
    curves = Curves()
    curves.draw("001", CURVE, 12.5, 0.25)
    header, arrays = parse_frame(curves.next_curve())
    assert (header["kind"], header["recording"], header["title"]) == ("curve", "001", "One cycle")
    assert header["x"] == {"name": "phase", "unit": "°", "low": 0.0, "high": 360.0}
    assert (header["t_s"], header["monotonic_s"], header["late_s"]) == (2.0, 12.5, 0.25)
    assert header["frequency_hz"] == 5.0
    assert {name: values.tolist() for name, values in arrays.items()} == {
        "x": [0, 180, 360], "measured": [1, 2, 1], "corrected": [0.5, 1.5, 0.5],
    }  # fmt: skip
    assert curves.next_curve() is None
    later = parse_frame(curves.all_frames()[1])[0]  # for a screen that connects later
    assert later.pop("late_s") >= header.pop("late_s")
    assert later == header


def test_late_screen_gets_the_age_of_the_curve(monkeypatch):
    now = iter([100.0, 160.0])
    monkeypatch.setattr(time, "monotonic", lambda: next(now))
    curves = Curves()
    curves.draw("001", CURVE, 12.5, 0.25)
    assert parse_frame(curves.all_frames()[1])[0]["late_s"] == 60.25


def test_only_the_latest_of_many_curves_are_sent():
    curves = Curves()
    for number in range(20):
        curves.draw("001", CURVE, float(number))
    ended_s = [parse_frame(frame)[0]["monotonic_s"] for frame in iter(curves.next_curve, None)]
    assert ended_s == [16, 17, 18, 19]


def test_trend_sends_only_new_columns_and_all_to_a_new_screen():
    curves = Curves()
    curves.take(samples("001", block_of(np.ones(2000))), 0.0, {})
    assert parse_frame(curves.next_trend())[0]["first"] == 0
    assert curves.next_trend() is None
    curves.take(samples("001", block_of(np.ones(2000), 2000)), 1.0, {})
    header, arrays = parse_frame(curves.next_trend())
    assert (header["first"], header["reset"], len(arrays["minimum"])) == (20, False, 20)
    header, arrays = parse_frame(curves.all_frames()[0])
    assert (header["first"], header["reset"], len(arrays["minimum"])) == (0, True, 40)


def test_trend_shows_first_listed_recorded_channel_in_its_display_unit():
    curves = Curves()
    air = np.linspace(293.15, 303.15, 200)
    block = Block(RATE_HZ, 0, 0.1, {"meter.resistance": 2 * air, "chamber.air": air})
    units = {"meter.voltage": "V", "chamber.air": "°C", "meter.resistance": "Ω"}
    curves.take(samples("001", block), 0, units)
    header, arrays = parse_frame(curves.next_trend())
    assert (header["channel"], header["unit"]) == ("chamber.air", "°C")
    assert arrays["minimum"].min() == pytest.approx(20, abs=1e-4)
    assert arrays["maximum"].max() == pytest.approx(30, abs=1e-4)
    curves.take(samples("002", block_of(np.ones(200), name="other.x")), 1.0, units)
    header, arrays = parse_frame(curves.next_trend())
    assert (header["channel"], header["unit"]) == ("other.x", "")
    assert np.nanmax(arrays["maximum"]) == 1  # nothing of the former channel
