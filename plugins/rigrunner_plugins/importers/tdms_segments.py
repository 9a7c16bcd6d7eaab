"""The segments of a TDMS file: whether the last one is torn, and when each began."""

from __future__ import annotations

import os
import struct
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, BinaryIO

import nptdms
import numpy as np

from rigrunner.api import DataError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path
    from typing import Any, TypeGuard

    from rigrunner.api import Location

BEGINS, _INDEX_BEGINS = b"TDSm", b"TDSh"
_LEAD_IN = 28
"""Bytes of it: see `segment_ends`."""
_BIG_ENDIAN = 1 << 6
"""The bit of the contents for big-endian numbers."""
_NEVER = datetime(1904, 1, 2, tzinfo=UTC)
"""A start up to this time is LabVIEW's zero: none was entered."""


def segment_ends(source: BinaryIO, size: int, place: Location) -> list[int]:
    """Return where each segment ends, in bytes.

    Raises DataError for another kind of file, and if the file ends within the description of its
    samples.

    npTDMS leaves such a segment out silently, so its samples would not be missed. A segment
    begins with a lead-in: tag, contents, version, and the distances from its end to the next
    segment and to its own samples (NI, TDMS File Format Internal Structure).
    """
    begins = source.read(len(BEGINS))
    if begins != BEGINS:
        hint = "this is the index of one" if begins == _INDEX_BEGINS else ""
        raise DataError("is not a TDMS file", location=place, hint=hint)
    position, ends = 0, []
    while position < size:
        source.seek(position)
        lead_in = source.read(_LEAD_IN)
        if len(lead_in) < _LEAD_IN or lead_in[: len(BEGINS)] != BEGINS:
            break
        order = ">" if lead_in[4] & _BIG_ENDIAN else "<"
        to_next, to_samples = struct.unpack(f"{order}QQ", lead_in[12:])
        if position + _LEAD_IN + to_samples > size:
            break
        position += _LEAD_IN + to_next
        # LabVIEW sets all bits of the distance before it knows it: that segment ends with the
        # file.
        ends.append(min(position, size))
    else:
        return ends
    raise DataError(
        f"is cut short or damaged in the segment that begins at byte {position}",
        location=place,
        hint="was the program that wrote it interrupted, or the copy?",
    )


def goes_of(
    path: Path, ends: Iterable[int], channel: nptdms.TdmsChannel
) -> tuple[tuple[int, datetime], ...]:
    """Return the first sample and the start of each go of a channel; none if it was one go.

    A file that was opened again, or a loop that writes each go with its time, states the start more
    than once; npTDMS knows the last. So the file is read as it was after each of its segments.
    """
    goes: list[tuple[int, datetime]] = []
    last, samples, final = None, 0, _start_of(channel.properties)
    with path.open("rb") as source:
        for end in ends:
            file = nptdms.TdmsFile.read_metadata(_Beginning(source, end))
            if channel.group_name not in file or channel.name not in file[channel.group_name]:
                continue
            so_far = file[channel.group_name][channel.name]
            start = _start_of(so_far.properties)
            if last is None and start == final:
                return ()
            if start is not None and start != last:
                goes.append((samples, start))
            last, samples = start or last, len(so_far)
    return tuple(goes)


class _Beginning:
    """The first bytes of a file, as a file."""

    def __init__(self, source: BinaryIO, size: int) -> None:
        self._source = source
        self._size = size
        source.seek(0)

    def read(self, count: int = -1) -> bytes:
        """Return that many bytes, or what is left."""
        left = max(self._size - self._source.tell(), 0)
        return self._source.read(left if count < 0 else min(count, left))

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Go to a place, and return it."""
        if whence == os.SEEK_END:
            return self._source.seek(self._size + offset)
        return self._source.seek(offset, whence)

    def tell(self) -> int:
        """Return the place."""
        return self._source.tell()

    def close(self) -> None:
        """Leave the file open: it belongs to the caller."""


def _start_of(properties: Mapping[str, Any]) -> datetime | None:
    start = utc_time(properties.get("wf_start_time"))
    offset_s = properties.get("wf_start_offset")
    return start and start + timedelta(seconds=float(offset_s) if is_number(offset_s) else 0.0)


def is_number(value: object) -> TypeGuard[float]:
    """Return whether the value of a property is a finite number."""
    return isinstance(value, (int, float, np.number)) and bool(np.isfinite(value))


def utc_time(time: object) -> datetime | None:
    """Return a time stamp of the file, which is in UTC."""
    if not isinstance(time, np.datetime64) or np.isnat(time):
        return None
    value = time.astype("datetime64[us]").astype(datetime)
    if not isinstance(value, datetime):  # a date that Python does not know
        return None
    start = value.replace(tzinfo=UTC)
    return start if start > _NEVER else None
