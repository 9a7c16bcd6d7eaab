"""Whether the thread that drives a rig makes progress: noted by it, looked at from another thread.

Progress is an event, a wait that has come to its next nap, or a call of a device that has returned.
A call may take as long as its own time limit says, and a person as long as they like.
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

    Time is what `tick` says, so that a computer that was suspended has not let any pass. `announce`
    is notified of each call that may take longer than usual, with its time in seconds, before it
    begins: a driver may keep every other thread from running meanwhile.
    """

    def __init__(self, usual_s: float, announce: Callable[[float], None] | None = None) -> None:
        self.usual_s = usual_s
        """How long it may take without a call of a device."""
        self._announce = announce
        self._now_s = self._given_up_s = 0.0
        self._until_s = usual_s
        self._people = 0

    def tick(self, seconds: float) -> None:
        """Let time pass."""
        self._now_s += seconds

    def left_s(self) -> float:
        """Return how much time is left until progress is overdue; infinity while a person acts."""
        return math.inf if self._people else self._until_s - self._now_s

    def note(self, event: object = None) -> None:  # noqa: ARG002  (an EventSink's)
        """Take note of progress; an event sink."""
        self._until_s = max(self._now_s + self.usual_s, self._given_up_s)

    @contextmanager
    def call(self, limit_s: float) -> Iterator[None]:
        """Allow a call of a device its time limit."""
        until_s = self._now_s + limit_s + self.usual_s
        self._until_s = max(self._until_s, until_s)
        if limit_s > self.usual_s and self._announce is not None:
            self._announce(limit_s + self.usual_s)
        try:
            yield
        except BaseException:  # it may have been given up, and is waited for once more in the end
            self._given_up_s = max(self._given_up_s, until_s)
            raise
        finally:
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


class NotedClock:
    """A clock whose naps are noted as progress: a wait of an hour consists of many."""

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


class NotedCaller:
    """Calls a device as another caller does, and allows each call its time."""

    def __init__(self, caller: Caller, pulse: Pulse) -> None:
        self._caller = caller
        self._pulse = pulse

    def call(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        """Return what the function returns; raise DeviceTimeoutError if that takes too long."""
        with self._pulse.call(timeout_s):
            return self._caller.call(what, function, timeout_s)

    def call_urgently(self, what: str, function: Callable[[], _T], timeout_s: float) -> _T:
        """Do the same even while an earlier call hangs."""
        with self._pulse.call(timeout_s):
            return self._caller.call_urgently(what, function, timeout_s)

    def start(self, what: str, function: Callable[[], _T]) -> Future[_T]:
        """Begin the call and return at once."""
        return self._caller.start(what, function)

    def stop(self) -> None:
        """Let go of the thread, if there is one."""
        self._caller.stop()
