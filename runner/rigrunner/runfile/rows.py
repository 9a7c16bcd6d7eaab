"""Points of scans in journals of an older form, before MessagePack.

The first point was stored whole, the others as numbers alone.
"""

from __future__ import annotations

import struct
from datetime import UTC, datetime, timedelta

from rigrunner.api.errors import DataError
from rigrunner.api.events import Scanned
from rigrunner.clock import utc_text

_FIXED = "<IdIq"
"""Number of the event, monotonic time, number of the point, milliseconds of UTC since 1970."""
_EPOCH, _MILLISECOND = datetime(1970, 1, 1, tzinfo=UTC), timedelta(milliseconds=1)


class Rows:
    """What the points of a scan have in common: the last one that was stored whole."""

    def __init__(self, whole: Scanned) -> None:
        self._whole = whole
        self._unpack = struct.Struct(f"{_FIXED}{len(whole.setpoints) + len(whole.values)}d").unpack

    def event_from(self, data: bytes) -> Scanned:
        """Return the point; raise DataError if it does not belong to this scan."""
        whole = self._whole
        try:
            seq, monotonic_s, point, milliseconds, *numbers = self._unpack(data)
            utc = utc_text(_EPOCH + milliseconds * _MILLISECOND)
        except (struct.error, OverflowError) as error:
            raise DataError(f"a record of the run is not a point of its scan: {error}") from error
        at = len(whole.setpoints)
        return Scanned(
            seq=seq,
            monotonic_s=monotonic_s,
            utc=utc,
            step=whole.step,
            point=point,
            measurement=whole.measurement,
            setpoints=dict(zip(whole.setpoints, numbers[:at], strict=True)),
            values=dict(zip(whole.values, numbers[at:], strict=True)),
        )
