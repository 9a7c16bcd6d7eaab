"""Ranges of values and times as text."""

from __future__ import annotations

from contextlib import suppress
from datetime import UTC, datetime, timedelta
from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.api.errors import UsageError
from rigrunner_fleet.archive.ranges import Range, range_of, since, until


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("0.5..0.8 N·m", 0.5, 0.8),
        ("0.5 .. 0.8 Nm", 0.5, 0.8),
        ("500 mN·m..0.8 N·m", 0.5, 0.8),
        ("500..800 mN·m", 0.5, 0.8),
        ("500 mN·m..800", 0.5, 0.8),
        ("..0.8 N·m", -inf, 0.8),
        ("0.5 N·m..", 0.5, inf),
        ("-1..1 N·m", -1, 1),
        ("\N{MINUS SIGN}1..\N{MINUS SIGN}0.5 N·m", -1, -0.5),
        ("1e-3..2e-3 N·m", 1e-3, 2e-3),
        ("0.7..0.7 N·m", 0.7, 0.7),
    ],
)
def test_a_range_is_read_in_si_units(text, low, high):
    parsed = range_of(text, "torque")
    assert (parsed.low, parsed.high) == (pytest.approx(low), pytest.approx(high))
    assert parsed.dimension == "torque"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0.5..0.8", "has no unit"),
        ("0.5..0.8 N", "is a force, not a torque"),
        ("0.8..0.5 N·m", "is empty"),
        ("0,5..0,8 N·m", "is not a number|decimal comma"),
        ("..", "is not a range"),
        ("", "is not a range"),
        ("0.7 N·m", "is not a range"),
        ("0...8 N·m", "is not a range"),
        ("0.1..0.2..0.3 N·m", "is not a range"),
        ("nan..1 N·m", "not a number"),
        ("0..inf N·m", "has no unit|not a number"),
        ("1..2 furlongs", "unknown unit"),
        ("0..1e400 N·m", "too large"),
        ("'; DROP TABLE runs..1 N·m", "not a number"),
    ],
)
def test_invalid_ranges_are_refused_with_a_hint(text, message):
    with pytest.raises(UsageError, match=message) as caught:
        range_of(text, "torque")
    assert caught.value.hint


def test_ends_of_different_dimensions_are_refused():
    with pytest.raises(UsageError, match="combines a torque with a force"):
        range_of("1 N·m..2 N")


def test_nominal_value_matches_itself_with_rounding():
    parsed = range_of("10 Hz", "frequency", nominal=True)
    assert parsed.low < 10 < parsed.high
    assert parsed.high - parsed.low == pytest.approx(2e-5)
    assert range_of("0 Hz", "frequency", nominal=True) == Range(0.0, 0.0, "frequency")


@given(st.text(max_size=30))
def test_any_text_is_a_range_or_a_usage_error(text):
    with suppress(UsageError):
        assert range_of(text).low <= range_of(text).high


@given(st.text(max_size=30))
def test_any_text_is_a_moment_or_a_usage_error(text):
    with suppress(UsageError):
        assert since(text) < until(text)


def test_day_is_a_whole_utc_day():
    assert since("2026-01-31") == datetime(2026, 1, 31, tzinfo=UTC)
    assert until("2026-01-31") == datetime(2026, 2, 1, tzinfo=UTC)


def test_time_zone_is_converted_to_utc():
    assert since("2026-01-31T00:30+01:00") == datetime(2026, 1, 30, 23, 30, tzinfo=UTC)
    assert since("2026-01-31T00:30") == datetime(2026, 1, 31, 0, 30, tzinfo=UTC)
    noon = datetime(2026, 1, 31, 12, tzinfo=UTC)
    assert until("2026-01-31T12:00Z") == noon + timedelta(milliseconds=1)


@pytest.mark.parametrize("text", ["31.01.2026", "2026-13-01", "yesterday", "9999-12-31", ""])
def test_invalid_days_are_refused(text):
    with pytest.raises(UsageError):
        until(text)
