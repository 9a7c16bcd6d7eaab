"""Progress of the thread that drives a rig, checked by another thread.

Progress is an event, an interval of a wait, or a returned call of a device. A call may take up to
its own time limit, and a person any time.
"""

from __future__ import annotations

import math
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from concurrent.futures import Future
    from datetime import datetime

    from rigrunner.api.calling import Caller
    from rigrunner.api.devices import Clock

_T = TypeVar("_T")


class Pulse:
    """How long the driving thread may still go without progress.

    Time is counted by `tick`, so that the suspension of a computer does not count. `announce` is
    called before each call that may take longer than usual, with its time in seconds, since a
    driver can block all other threads.
    """

    def __init__(self, usual_s: float, announce: Callable[[float], None] | None = None) -> None:
        self.usual_s = usual_s
        """Allowed time without a call of a device."""
        self._announce = announce
        self._now_s = self._given_up_s = 0.0
        self._until_s = usual_s
        self._people = 0
        self._running: list[float] = []
        """When each call in progress exceeds its time limit; devices are made safe side by side."""

    def tick(self, seconds: float) -> None:
        """Let time pass."""
        self._now_s += seconds

    def left_s(self) -> float:
        """Return the time until progress is overdue; infinity while a person acts."""
        if self._people:
            return math.inf
        # Compared here: a thread that notes progress then loses no call that begins meanwhile.
        return max(self._until_s, self._given_up_s, *self._running) - self._now_s

    def note(self, event: object = None) -> None:  # noqa: ARG002  (of an EventSink)
        """Note progress; an event sink."""
        self._until_s = self._now_s + self.usual_s

    @contextmanager
    def call(self, limit_s: float) -> Iterator[None]:
        """Allow a call of a device its time limit."""
        until_s = self._now_s + limit_s + self.usual_s
        self._running.append(until_s)
        if limit_s > self.usual_s and self._announce is not None:
            self._announce(limit_s + self.usual_s)
        try:
            yield
        except BaseException:  # if it was given up, it is waited for again at the end
            self._given_up_s = max(self._given_up_s, until_s)
            raise
        finally:
            self._running.remove(until_s)
            self.note()

    @contextmanager
    def person(self) -> Iterator[None]:
        """Allow a person any time."""
        self._people += 1
        try:
            yield
        finally:
            self._people -= 1
            self.note()


class PulseClock:
    """A clock whose waits note progress at each interval."""

    def __init__(self, clock: Clock, pulse: Pulse) -> None:
        self._clock = clock
        self._note = pulse.note
        self.monotonic_s = clock.monotonic_s

    def utc(self) -> datetime:
        """Return the date and time, in UTC."""
        return self._clock.utc()

    def sleep(self, seconds: float) -> None:
        """Wait."""
        self._note()
        self._clock.sleep(seconds)
        self._note()


class PulseCaller:
    """Calls a device through another caller, and allows each call its time limit."""

    def __init__(self, caller: Caller, pulse: Pulse) -> None:
        self._caller = caller
        self._pulse = pulse

    def call(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        """Return the result of the function; raise DeviceTimeoutError if it takes too long."""
        with self._pulse.call(timeout_s):
            return self._caller.call(what, function, timeout_s)

    def call_urgently(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        """Call even while an earlier call hangs."""
        with self._pulse.call(timeout_s):
            return self._caller.call_urgently(what, function, timeout_s)

    def start(self, what: str, function: Callable[[], _T]) -> Future[_T]:
        """Start the call and return at once."""
        return self._caller.start(what, function)

    def stop(self) -> None:
        """Release the thread, if there is one."""
        self._caller.stop()
