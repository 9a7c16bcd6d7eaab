"""Recorded and replayed clocks: a replay reads the times of the run."""

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
    """A Clock whose readings are recorded on a wire."""

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
        """Wait for a duration."""
        self._wire.exchange(_sleep(seconds), lambda: self._clock.sleep(seconds))


class ReplayedClock:
    """A Clock with the readings of a tape; `start_utc` until the first one.

    It never raises, since code that reads a clock does not expect that. After a difference, or at
    the end of the tape, only waiting advances it, and the next exchange with an instrument reports
    the difference.
    """

    def __init__(self, wire: ReplayWire, start_utc: datetime) -> None:
        self._wire = wire
        self._monotonic_s = 0.0
        self._utc = start_utc

    def monotonic_s(self) -> float:
        """Return the recorded seconds, plus any waiting since."""
        reading = self._wire.reading(MONOTONIC)
        if isinstance(reading, float):
            self._monotonic_s = reading
        return self._monotonic_s

    def utc(self) -> datetime:
        """Return the recorded date and time, plus any waiting since."""
        reading = self._wire.reading(UTC)
        if isinstance(reading, str):
            self._utc = datetime.fromisoformat(reading)
        return self._utc

    def sleep(self, seconds: float) -> None:
        """Do not wait."""
        self._wire.reading(_sleep(seconds))
        self._monotonic_s += seconds
        self._utc += timedelta(seconds=seconds)
