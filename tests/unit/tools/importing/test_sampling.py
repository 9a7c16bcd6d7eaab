"""The sampling rate and start, as stated, from the file, and from times."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner.api.importing import Column
from rigrunner.tools.importing.sampling import rate_of, start_of

VALUES = np.zeros(1001)


def column(interval_s=None, within_s=0.0):
    return {"x": Column(VALUES, interval_s=interval_s, interval_within_s=within_s)}


def times(rate_hz, digits=None, count=1001):
    even = 5.0 + np.arange(count) / rate_hz
    return even if digits is None else np.round(even, digits)


@pytest.mark.parametrize(
    ("columns", "times_s", "stated_hz", "expected"),
    [
        (column(), None, 12_800.0, 12_800.0),
        (column(1e-4), None, None, 1 / 1e-4),
        (column(1e-4), None, 10_000.0, 10_000.0),
        (column(0.000078, 5e-7), None, 12_800.0, 12_800.0),
        (column(), times(12_800.0), 12_800.0, 12_800.0),
        (column(), times(12_800.0, 5), 12_800.0, 12_800.0),
        (column(1e-3), times(1000.0, 4), None, 1000.0),
    ],
)
def test_rate_is_derived_from_all_sources(columns, times_s, stated_hz, expected):
    assert rate_of(columns, times_s, stated_hz, "f") == expected


def test_rate_is_derived_within_the_digits_of_the_times():
    assert rate_of(column(), times(12_800.0, 6), None, "f") == pytest.approx(12_800.0, rel=2e-5)


@pytest.mark.parametrize(
    ("columns", "times_s", "stated_hz", "message"),
    [
        (column(), None, None, "the sampling rate is missing"),
        (column(0.0001, 5e-7), None, None, "the rate may be 9950.25 Hz to 10050.3 Hz"),
        (column(1e-4), None, 9_999.0, "states an interval of 0.0001 s for 'x', which is not that"),
        (column(2e-4), times(10_000.0), None, "states an interval of 0.0002 s"),
        (column(), np.delete(times(1000.0), 700), None, "sample 701 comes 0.002 s after"),
        (column(), np.delete(times(1000.0), 700), 1000.0, "sample 701 comes 0.002 s after"),
        (column(), times(1001.0), 1000.0, "intervals away from its place in an even series"),
        (column(), times(10_000.0, 3), 10_000.0, "not evenly spaced"),
        (column(), times(1000.0)[::-1], None, "the times of the samples do not increase"),
        (column(), times(1000.0)[:1], None, "the times of the samples do not increase"),
        (column(), np.zeros(1001), 1000.0, "the times of the samples do not increase"),
    ],
)
def test_contradictory_or_uneven_sampling_is_refused(columns, times_s, stated_hz, message):
    with pytest.raises(DataError) as caught:
        rate_of(columns, times_s, stated_hz, "run.csv")
    assert message in str(caught.value)
    assert str(caught.value).startswith("run.csv: ")


NOON = datetime(2026, 3, 2, 12, tzinfo=UTC)


def started(*offsets_s):
    starts = [None if s is None else NOON + timedelta(seconds=s) for s in offsets_s]
    return {f"c{i}": Column(VALUES, started=start) for i, start in enumerate(starts)}


def test_first_sample_is_at_start_plus_offset():
    column = Column(VALUES, started=NOON, offset_s=0.25)
    assert start_of({"x": column, "y": column}, 1e4, "f") == NOON + timedelta(seconds=0.25)
    assert start_of(started(None, None), 1e4, "f") is None
    assert start_of(started(None, 1.0), 1e4, "f") == NOON + timedelta(seconds=1)
    assert start_of(started(0.0, 1e-6), 1e4, "f") == NOON


def test_channels_with_different_starts_are_refused():
    with pytest.raises(DataError, match="f: 'c1' begins 5e-05 s after 'c0'"):
        start_of(started(0.0, 5e-5), 1e4, "f")
    late = {"x": Column(VALUES), "y": Column(VALUES, offset_s=5e-5)}
    with pytest.raises(DataError, match="f: 'y' begins 5e-05 s after 'x'"):
        start_of(late, 1e4, "f")
    same = {"x": Column(VALUES, started=NOON, offset_s=0.5), **started(0.5)}
    assert start_of(same, 1e4, "f") == NOON + timedelta(seconds=0.5)


@pytest.mark.parametrize("late_s", [0.0, 4e-5, 0.01, -0.01])
def test_gap_between_written_segments_is_refused(late_s):
    goes = ((400, NOON + timedelta(seconds=0.04)), (700, NOON + timedelta(seconds=0.07 + late_s)))
    columns = {"x": Column(VALUES, started=NOON, goes=goes)}
    if abs(late_s) < 5e-5:
        assert start_of(columns, 1e4, "f") == NOON
        return
    with pytest.raises(DataError, match=f"'x' has a gap: sample 701 was taken {late_s:g} s later"):
        start_of(columns, 1e4, "f")
