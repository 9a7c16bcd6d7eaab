"""Time on tape: what was read is read again, so that a replay sees no other time than the run."""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rigrunner.api.devices import Clock, Wire
    from rigrunner.tape.replaying import ReplayWire

MONOTONIC, UTC = "clock: seconds", "clock: date and time"


def _sleep(seconds: float) -> str:
    return f"clock: sleep {seconds!r} s"


class RecordedClock:
    """A Clock whose readings are saved on a wire."""

    def __init__(self, clock: Clock, wire: Wire) -> None:
        self._clock = clock
        self._wire = wire

    def monotonic_s(self) -> float:
        """Return seconds since an arbitrary start."""
        return self._wire.exchange(MONOTONIC, self._clock.monotonic_s)

    def utc(self) -> datetime:
        """Return the date and time, in UTC."""
        text = self._wire.exchange(UTC, lambda: self._clock.utc().isoformat())
        return datetime.fromisoformat(text)

    def sleep(self, seconds: float) -> None:
        """Let that much time pass."""
        self._wire.exchange(_sleep(seconds), lambda: self._clock.sleep(seconds))


class ReplayedClock:
    """A Clock that tells the times of a tape; `start_utc` until the first is read.

    It never raises: code that reads a clock is not made for that. After a difference, or at the end
    of the tape, it goes on by what is slept, and the next exchange with an instrument tells it.
    """

    def __init__(self, wire: ReplayWire, start_utc: datetime) -> None:
        self._wire = wire
        self._monotonic_s = 0.0
        self._utc = start_utc

    def monotonic_s(self) -> float:
        """Return the seconds that were read, or as many as were slept since."""
        found = self._wire.reading(MONOTONIC)
        if isinstance(found, float):
            self._monotonic_s = found
        return self._monotonic_s

    def utc(self) -> datetime:
        """Return the date and time that was read, or as much later as was slept since."""
        found = self._wire.reading(UTC)
        if isinstance(found, str):
            self._utc = datetime.fromisoformat(found)
        return self._utc

    def sleep(self, seconds: float) -> None:
        """Do not wait."""
        self._wire.reading(_sleep(seconds))
        self._monotonic_s += seconds
        self._utc += timedelta(seconds=seconds)
