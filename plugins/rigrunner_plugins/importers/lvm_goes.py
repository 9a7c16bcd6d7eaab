"""Recordings that LabVIEW wrote in several goes, each a segment of an LVM file of its own."""

from __future__ import annotations

import re
from datetime import timedelta
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Column, DataError, NotInFileError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from datetime import datetime

    from rigrunner.api import Location

ALL = 1_000_000
"""More segments than a file has."""


def segment_range(group: str) -> range | None:
    """Return the numbers of the segments that a group names; None where it names none."""
    if not group:
        return None
    if group == "all":
        return range(1, ALL + 1)
    found = re.fullmatch(r"([1-9][0-9]{0,5})(?:-([1-9][0-9]{0,5}))?", group, re.ASCII)
    if found is None or int(found[2] or found[1]) < int(found[1]):
        hint = "such as 3, 1-20, or all"
        raise NotInFileError(f"'{group[:40]}' names no segments", hint=hint)
    return range(int(found[1]), int(found[2] or found[1]) + 1)


def joined(segments: Sequence[dict[str, Column]], place: Location) -> dict[str, Column]:
    """Return the columns of segments that follow each other, with the time at which each begins."""
    if len(segments) == 1:
        return segments[0]
    return {name: _joined(name, [each[name] for each in segments], place) for name in segments[0]}


def _joined(name: str, columns: Sequence[Column], place: Location) -> Column:
    first = columns[0]
    for number, each in enumerate(columns[1:], 2):
        if (each.unit, each.interval_s) != (first.unit, first.interval_s):
            what = f"segment {number} of '{name}' has another unit or interval than the first"
            raise DataError(what, location=place)
    ends = np.cumsum([len(each.values) for each in columns])
    begun = [_begun(name, each, place) for each in columns]
    return Column(
        np.concatenate([each.values for each in columns]),
        unit=first.unit,
        interval_s=first.interval_s,
        interval_within_s=first.interval_within_s,
        started=first.started,
        offset_s=first.offset_s,
        goes=tuple(zip(ends[:-1].tolist(), begun[1:], strict=True)),
    )


def _begun(name: str, column: Column, place: Location) -> datetime:
    if column.started is None:
        raise DataError(
            f"'{name}' does not say when each segment began, so nobody knows of gaps",
            location=place,
            hint="take one segment, or write the recording in one go",
        )
    return column.started + timedelta(seconds=column.offset_s)
