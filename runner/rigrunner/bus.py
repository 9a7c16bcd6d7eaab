"""How events reach those who listen: critical sinks stop the run when they fail, guarded do not."""

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
    """Hands every event to all sinks, critical ones first.

    A sink that raises gets no further event: what it would do half-broken is unknown.
    """

    def __init__(
        self,
        critical: Iterable[EventSink] = (),
        guarded: Iterable[EventSink] = (),
        tracers: Iterable[Callable[[BaseException], None]] = (),
    ) -> None:
        """Make it; `tracers` are told the errors themselves of which events tell in words."""
        self._tracers = tuple(tracers)
        self._critical = tuple(critical)
        self._guarded = tuple(guarded)
        self.failure: Exception | None = None
        """The first error of a critical sink: what came after it may not be on record."""

    def trace(self, error: BaseException) -> None:
        """Tell an error whose event was just handed out to those who keep tracebacks."""
        for tracer in self._tracers:
            with suppress(Exception):  # it is on record in words
                tracer(error)

    def emit(self, event: Event) -> tuple[str, ...]:
        """Hand out the event and say, in words, which guarded sinks were dropped by it.

        The first error of a critical sink is raised after all others have had the event.
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
            except Exception as error:  # noqa: BLE001  (a stranger's listener may raise anything)
                self._guarded = _without(sink, self._guarded)
                why = f"{type(error).__name__}: {error}"
                dropped += (f"{_name(sink)} failed and was dropped: {why}",)
        if failures:
            self.failure = self.failure or failures[0]
            raise_first(failures)
        return dropped


def _without(sink: EventSink, sinks: tuple[EventSink, ...]) -> tuple[EventSink, ...]:
    """Return new sinks: those that are being told an event are told it in peace."""
    return tuple(one for one in sinks if one is not sink)


_MILLISECOND = timedelta(milliseconds=1)
SET_BACK = timedelta(seconds=1)
"""A time server moves a clock by less."""


class Emit(Protocol):
    """Puts an event on the bus."""

    def __call__(self, kind: type[Event], /, **fields: Any) -> None:
        """Stamp and hand out an event of that kind."""
        ...


class Emitter:
    """Numbers and times events and puts them on a bus; the only source of a run's events.

    An alarm says so if the machine's clock was set back: then times of day are out of order, while
    durations are not affected.
    """

    def __init__(self, bus: Bus, clock: Clock, first_seq: int = 0) -> None:
        self._bus = bus
        self._stamp = EventStamp(clock, first_seq, self._tell_set_back)

    def __call__(self, kind: type[Event], /, **fields: Any) -> None:
        """Emit one event; an Alarm follows for each guarded sink that failed on it."""
        for text in self._bus.emit(self._stamp(kind, **fields)):
            self(Alarm, source="event sink", text=text)

    def _tell_set_back(self, latest: datetime, now: datetime) -> None:
        if latest - now > SET_BACK:
            was = f"the clock was set back from {utc_text(latest)} to {utc_text(now)}"
            self(Alarm, source="clock", text=f"{was}; durations are measured by another one")


class EventStamp:
    """Makes events with consecutive sequence numbers and the clock's time."""

    def __init__(
        self,
        clock: Clock,
        first_seq: int = 0,
        set_back: Callable[[datetime, datetime], None] = lambda *_: None,
    ) -> None:
        """Begin; `set_back` is told the latest time and the present one, if that is before it."""
        self._clock = clock
        self._seq = itertools.count(first_seq)
        self._set_back = set_back
        self._from = self._until = clock.utc()
        self._utc = ""
        """The text of the time of day from the one to the other: of one millisecond."""

    def __call__(self, kind: type[_E], **fields: Any) -> _E:
        """Return an event of that kind, stamped."""
        monotonic_s, now = self._clock.monotonic_s(), self._clock.utc()
        if not self._from <= now < self._until:
            latest = self._from
            self._from = now.replace(microsecond=now.microsecond // 1000 * 1000)
            self._until, self._utc = self._from + _MILLISECOND, utc_text(now)
            if now < latest:
                self._set_back(latest, now)
        return kind(seq=next(self._seq), monotonic_s=monotonic_s, utc=self._utc, **fields)


def _name(sink: EventSink) -> str:
    return getattr(sink, "__name__", type(sink).__name__)
