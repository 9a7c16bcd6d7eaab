"""Find the sampling rate from the mapping, the file, or the times of the samples."""

from __future__ import annotations

from datetime import timedelta
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import DataError, Location

if TYPE_CHECKING:
    from collections.abc import Mapping
    from datetime import datetime

    from rigrunner.api.data import Array
    from rigrunner.api.importing import Column

INTERVAL_TOLERANCE = 1e-4
"""Relative uncertainty up to which a file's own interval needs no confirmation."""
_ROUNDING = 1e-6
"""Relative difference of two intervals that are the same but for rounding."""
_MAX_OFFSET = 0.25
"""Largest distance, in intervals, of a time from its place in an even series: digits are rounded.
"""
_GAP = 0.5
"""Distance, in intervals, from which a time is nearer to the place of another sample."""
_START_TOLERANCE = 0.01
"""Largest difference, in intervals, between the starts of two channels."""
_RESOLUTION_S = 2e-6
"""Resolution of the times in files; Python's own is a microsecond."""


def rate_of(
    columns: Mapping[str, Column], times_s: Array | None, stated_hz: float | None, where: str
) -> float:
    """Return the samples per second of a recording in the file `where`, from all sources.

    `times_s` are the times of the samples, `stated_hz` is from the mapping. Raises DataError if no
    source is accurate enough, and if two disagree.
    """
    place = Location(where)
    rate_hz = stated_hz
    if times_s is not None:
        rate_hz = _checked_times(times_s, stated_hz, place)
    if rate_hz is None:
        rate_hz = _from_intervals(columns, place)
    for name, column in columns.items():
        own_s = column.interval_s
        if own_s is None:
            continue
        if abs(1 / rate_hz - own_s) > column.interval_within_s + _ROUNDING * own_s:
            raise DataError(
                f"the file states an interval of {own_s:.9g} s for '{name}', which is not that of"
                f" {rate_hz:.9g} Hz",
                location=place,
            )
    return rate_hz


def start_of(columns: Mapping[str, Column], rate_hz: float, where: str) -> datetime | None:
    """Return when the first samples were taken, from the file `where`, or None.

    Raises DataError if columns begin at different times (a force that is late against its path
    gives another result, unnoticed), and for a gap between two segments.
    """
    dated = {name: column for name, column in columns.items() if column.started} or dict(columns)
    (first, origin), *others = dated.items()
    for name, column in others:
        late_s = column.offset_s - origin.offset_s
        if column.started and origin.started:
            late_s += (column.started - origin.started).total_seconds()
        if abs(late_s) > max(_START_TOLERANCE / rate_hz, _RESOLUTION_S):
            raise DataError(
                f"'{name}' begins {late_s:.6g} s after '{first}'",
                location=Location(where),
                hint="the channels of a recording are sampled at the same times",
            )
    begun = origin.started and origin.started + timedelta(seconds=origin.offset_s)
    if begun is None:
        return None
    # each segment begins where the one before it ended
    segments = [(name, *segment) for name, column in columns.items() for segment in column.goes]
    for name, sample, time in segments:
        late_s = (time - begun).total_seconds() - sample / rate_hz
        if abs(late_s) > max(_GAP / rate_hz, _RESOLUTION_S):
            raise DataError(
                f"'{name}' has a gap: sample {sample + 1} was taken {late_s:.6g} s later than"
                " the samples before it imply",
                location=Location(where),
                hint="segments make one recording only without gaps between them",
            )
    return begun


def _checked_times(times_s: Array, stated_hz: float | None, place: Location) -> float:
    """Return the rate of times, shape (n,), which have equal intervals."""
    intervals = len(times_s) - 1
    span_s = float(times_s[-1] - times_s[0]) if intervals > 0 else 0.0
    if span_s <= 0:
        raise DataError("the times of the samples do not increase", location=place)
    steps_s = np.diff(times_s)
    if stated_hz is not None:
        step_s = 1 / stated_hz
    else:  # the usual one; of times with few digits it may be 0
        step_s = float(np.median(steps_s)) or span_s / intervals
    gaps = np.flatnonzero(np.abs(steps_s - step_s) > _GAP * step_s)
    if gaps.size:
        at = int(gaps[0])
        raise DataError(
            f"sample {at + 2} comes {times_s[at + 1] - times_s[at]:.6g} s after the one before,"
            f" others {step_s:.6g} s: the samples are not evenly spaced",
            location=place,
            hint="a recording has no gaps; were the times written with too few digits?",
        )
    if stated_hz is None:
        step_s = span_s / intervals
    away = np.abs(times_s - times_s[0] - step_s * np.arange(intervals + 1)) / step_s
    if away.max() > _MAX_OFFSET:
        at = int(np.argmax(away > _MAX_OFFSET))
        raise DataError(
            f"sample {at + 1} is {away[at]:.2g} intervals away from its place in an even series"
            f" of {1 / step_s:.6g} Hz",
            location=place,
            hint="is the rate right?" if stated_hz is not None else "",
        )
    return stated_hz if stated_hz is not None else 1 / step_s


def _from_intervals(columns: Mapping[str, Column], place: Location) -> float:
    for column in columns.values():
        if column.interval_s is None:
            continue
        if column.interval_within_s > INTERVAL_TOLERANCE * column.interval_s:
            low_hz = 1 / (column.interval_s + column.interval_within_s)
            high_hz = 1 / max(column.interval_s - column.interval_within_s, 1e-12)
            raise DataError(
                "the file writes its interval with too few digits: the rate may be"
                f" {low_hz:.6g} Hz to {high_hz:.6g} Hz",
                location=place,
                hint="state it, such as sampling: {rate: 10 kHz}",
            )
        return 1 / column.interval_s
    raise DataError(
        "the sampling rate is missing",
        location=place,
        hint="such as sampling: {rate: 10 kHz}, or sampling: {time: {column: Time, unit: s}}",
    )
