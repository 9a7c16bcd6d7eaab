"""Delivers events to sinks: a critical sink that fails stops the run, a guarded one does not."""

from __future__ import annotations

import itertools
from contextlib import suppress
from datetime import timedelta
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from rigrunner.api.cleanup import raise_first
from rigrunner.api.events import Alarm, Event
from rigrunner.clock import utc_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from datetime import datetime

    from rigrunner.api.devices import Clock
    from rigrunner.api.events import EventSink

_E = TypeVar("_E", bound=Event)


class Bus:
    """Passes every event to all sinks, critical ones first.

    A sink that raised gets no further events, since its state is unknown.
    """

    def __init__(
        self,
        critical: Iterable[EventSink] = (),
        guarded: Iterable[EventSink] = (),
        tracers: Iterable[Callable[[BaseException], None]] = (),
    ) -> None:
        """Make a bus; `tracers` get the exceptions that events report as text."""
        self._tracers = tuple(tracers)
        self._critical = tuple(critical)
        self._guarded = tuple(guarded)
        self.failure: Exception | None = None
        """The first error of a critical sink; later events may not be recorded."""

    def trace(self, error: BaseException) -> None:
        """Pass an exception to the tracers; its event was emitted just before."""
        for tracer in self._tracers:
            with suppress(Exception):  # the event has recorded it as text
                tracer(error)

    def emit(self, event: Event) -> tuple[str, ...]:
        """Pass the event to all sinks; return a message for each guarded sink that failed.

        The first error of a critical sink is raised once all sinks have had the event.
        """
        failures: tuple[Exception, ...] = ()
        dropped: tuple[str, ...] = ()
        for sink in self._critical:
            try:
                sink(event)
            except Exception as error:  # noqa: BLE001  (raised again once all sinks have the event)
                self._critical = _without(sink, self._critical)
                failures += (error,)
        for sink in self._guarded:
            try:
                sink(event)
            except Exception as error:  # noqa: BLE001  (a listener of a plugin may raise anything)
                self._guarded = _without(sink, self._guarded)
                name = getattr(sink, "__name__", type(sink).__name__)
                reason = f"{type(error).__name__}: {error}"
                dropped += (f"{name} failed and was dropped: {reason}",)
        if failures:
            self.failure = self.failure or failures[0]
            raise_first(failures)
        return dropped


def _without(sink: EventSink, sinks: tuple[EventSink, ...]) -> tuple[EventSink, ...]:
    """Return a new tuple: an iteration over the old one is not disturbed."""
    return tuple(other for other in sinks if other is not sink)


_MILLISECOND = timedelta(milliseconds=1)
SET_BACK = timedelta(seconds=1)
"""A step larger than those of a time server."""


class Emit(Protocol):
    """Puts an event on the bus."""

    def __call__(self, kind: type[Event], /, **fields: Any) -> None:
        """Stamp an event of that kind and emit it."""
        ...


class Emitter:
    """Numbers and times events and puts them on a bus; the only source of a run's events.

    An alarm is raised if the clock of the machine was set back: times of day are then out of order;
    durations are not affected.
    """

    def __init__(self, bus: Bus, clock: Clock, first_seq: int = 0) -> None:
        self._bus = bus
        self._stamp = EventStamp(clock, first_seq, self._report_set_back)

    def __call__(self, kind: type[Event], /, **fields: Any) -> None:
        """Emit one event; an Alarm follows for each guarded sink that failed on it."""
        # It ends: a sink that failed is dropped, and does not get the alarm about it.
        for text in self._bus.emit(self._stamp(kind, **fields)):
            self(Alarm, source="event sink", text=text)

    def _report_set_back(self, latest: datetime, now: datetime) -> None:
        if latest - now > SET_BACK:
            message = f"the clock was set back from {utc_text(latest)} to {utc_text(now)}"
            self(Alarm, source="clock", text=f"{message}; durations are not affected")


class EventStamp:
    """Makes events with consecutive sequence numbers and the clock's time."""

    def __init__(
        self,
        clock: Clock,
        first_seq: int = 0,
        set_back: Callable[[datetime, datetime], None] = lambda *_: None,
    ) -> None:
        """Call `set_back` with the latest and the present time if the present one is earlier."""
        self._clock = clock
        self._seq = itertools.count(first_seq)
        self._set_back = set_back
        self._from = self._until = clock.utc()
        self._utc = ""
        """The text of the time of day, valid for the millisecond between the two."""

    def __call__(self, kind: type[_E], **fields: Any) -> _E:
        """Return an event of that kind, stamped."""
        monotonic_s, now = self._clock.monotonic_s(), self._clock.utc()
        # Both bounds: the clock of the machine may be set back.
        if not self._from <= now < self._until:
            latest = self._from
            self._from = now.replace(microsecond=now.microsecond // 1000 * 1000)
            self._until, self._utc = self._from + _MILLISECOND, utc_text(now)
            if now < latest:
                self._set_back(latest, now)
        return kind(seq=next(self._seq), monotonic_s=monotonic_s, utc=self._utc, **fields)
