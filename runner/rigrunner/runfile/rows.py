"""The points of a scan in the journal: the first is kept whole, of the others the numbers alone.

What a scan reads is the same at each of its points, and as JSON the names are most of it.
"""

from __future__ import annotations

import struct
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.api.events import Scanned
from rigrunner.clock import utc_text

if TYPE_CHECKING:
    from collections.abc import Callable

_FIXED = "<IdIq"
"""Number of the event, monotonic time, number of the point, milliseconds of UTC since 1970."""
_EPOCH, _MILLISECOND = datetime(1970, 1, 1, tzinfo=UTC), timedelta(milliseconds=1)


class Rows:
    """What the points of a scan have in common: as the last one that was kept, or read, whole."""

    def __init__(self, whole: Scanned) -> None:
        self._step, self._table = whole.step, whole.measurement
        self._members = (*whole.setpoints, *whole.values)
        self._utc: str | None = None
        self._milliseconds = 0
        self._split = len(whole.setpoints)
        form = struct.Struct(f"{_FIXED}{len(self._members)}d")
        self._pack: Callable[..., bytes] = form.pack
        self._unpack = form.unpack

    def bytes_of(self, event: Scanned) -> bytes | None:
        """Return the numbers of a point, from which `event_from` makes the same; None if not so."""
        setpoints, values = event.setpoints, event.values
        if (*setpoints, *values) != self._members or event.step != self._step:
            return None
        numbers = *setpoints.values(), *values.values()
        try:
            if event.utc is not self._utc:  # the same text for as long as it says the same
                self._utc, self._milliseconds = event.utc, _milliseconds(event.utc)
            return self._pack(
                event.seq, event.monotonic_s, event.point, self._milliseconds, *numbers
            )
        except (ValueError, struct.error):
            return None

    def event_from(self, data: bytes) -> Scanned:
        """Return the point; raise DataError if it is none of this scan."""
        try:
            seq, monotonic_s, point, milliseconds, *numbers = self._unpack(data)
            text = utc_text(_EPOCH + milliseconds * _MILLISECOND)
        except (struct.error, OverflowError) as error:
            raise DataError(f"a record of the run is not a point of its scan: {error}") from error
        at = self._split
        return Scanned(
            seq=seq,
            monotonic_s=monotonic_s,
            utc=text,
            step=self._step,
            point=point,
            measurement=self._table,
            setpoints=dict(zip(self._members[:at], numbers[:at], strict=True)),
            values=dict(zip(self._members[at:], numbers[at:], strict=True)),
        )


def _milliseconds(text: str) -> int:
    """Return a date and time as milliseconds since 1970; raise ValueError for any other text."""
    moment = datetime.fromisoformat(text)
    if utc_text(moment) != text:
        raise ValueError(text)
    return (moment - _EPOCH) // _MILLISECOND
