"""Whether a call of a device is running in this thread: only then is the clock recorded.

A driver can have its own thread, such as one that listens to a serial line. Its readings of the
clock happen at random times, with which no replay could agree.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable
    from datetime import datetime

    from rigrunner.api.devices import Clock

_T = TypeVar("_T")


class Calls(threading.local):
    """A Wire for the calls of a device, which only marks that one is running."""

    going_on = False

    def exchange(self, request: str, perform: Callable[[], _T]) -> _T:  # noqa: ARG002  (a Wire's)
        """Return what `perform` does."""
        before, self.going_on = self.going_on, True
        try:
            return perform()
        finally:
            self.going_on = before


class CallClock:
    """A Clock that is recorded during the calls of a device only."""

    def __init__(self, taped: Clock, plain: Clock, calls: Calls) -> None:
        self._taped = taped
        self._plain = plain
        self._calls = calls

    @property
    def _clock(self) -> Clock:
        return self._taped if self._calls.going_on else self._plain

    def monotonic_s(self) -> float:
        """Return seconds since an arbitrary start."""
        return self._clock.monotonic_s()

    def utc(self) -> datetime:
        """Return the date and time, in UTC."""
        return self._clock.utc()

    def sleep(self, seconds: float) -> None:
        """Let that much time pass."""
        self._clock.sleep(seconds)
