"""Time as devices and the engine see it: the wall's, or a simulated one that runs on demand."""

from __future__ import annotations

import threading
import time
from datetime import UTC, datetime, timedelta


def utc_text(moment: datetime) -> str:
    """Return an aware time as ISO 8601 in UTC with milliseconds: '2026-03-01T12:00:00.000Z'."""
    in_utc = moment if moment.tzinfo is UTC else moment.astimezone(UTC)
    return in_utc.isoformat(timespec="milliseconds").removesuffix("+00:00") + "Z"


class WallClock:
    """The time of the machine; a Clock."""

    monotonic_s = staticmethod(time.monotonic)
    """Seconds since an arbitrary start; read for every event, so without a wrapper call."""

    def utc(self) -> datetime:
        """Return the machine's date and time, in UTC."""
        return datetime.now(UTC)

    def sleep(self, seconds: float) -> None:
        """Wait."""
        time.sleep(seconds)


class SimulatedClock:
    """Time that passes only during `sleep`, and then at once; a Clock for any thread."""

    def __init__(self, start_utc: datetime | None = None) -> None:
        self._start_utc = (start_utc or datetime.now(UTC)).astimezone(UTC)
        self._elapsed_s = 0.0
        self._lock = threading.Lock()

    def monotonic_s(self) -> float:
        """Return the simulated seconds since the clock was made."""
        return self._elapsed_s

    def utc(self) -> datetime:
        """Return the start plus the simulated seconds, in UTC."""
        return self._start_utc + timedelta(seconds=self._elapsed_s)

    def sleep(self, seconds: float) -> None:
        """Let simulated time pass; raise ValueError for a negative or not finite one."""
        if not 0 <= seconds < float("inf"):
            raise ValueError(f"cannot sleep for {seconds} s")
        with self._lock:
            self._elapsed_s += seconds
