"""How events reach those who listen: critical sinks stop the run when they fail, guarded do not."""

from __future__ import annotations

import itertools
from datetime import timedelta
from typing import TYPE_CHECKING, Any, TypeVar

from rigrunner.api.events import Alarm, Event
from rigrunner.clock import utc_text

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.devices import Clock
    from rigrunner.api.events import EventSink

_E = TypeVar("_E", bound=Event)


class Bus:
    """Hands every event to all sinks, critical ones first.

    A sink that raises gets no further event: what it would do half-broken is unknown.
    """

    def __init__(
        self, critical: Iterable[EventSink] = (), guarded: Iterable[EventSink] = ()
    ) -> None:
        self._critical = list(critical)
        self._guarded = list(guarded)

    def emit(self, event: Event) -> list[str]:
        """Hand out the event and say, in words, which guarded sinks were dropped by it.

        The first error of a critical sink is raised after all others have had the event.
        """
        failures = [error for sink in tuple(self._critical) if (error := self._try(sink, event))]
        dropped = [text for sink in tuple(self._guarded) if (text := self._guard(sink, event))]
        if failures:
            raise failures[0]
        return dropped

    def _try(self, sink: EventSink, event: Event) -> Exception | None:
        try:
            sink(event)
        except Exception as error:  # noqa: BLE001  (raised again once all sinks have the event)
            self._critical.remove(sink)
            return error
        return None

    def _guard(self, sink: EventSink, event: Event) -> str:
        try:
            sink(event)
        except Exception as error:  # noqa: BLE001  (a stranger's listener may raise anything)
            self._guarded.remove(sink)
            return f"{_name(sink)} failed and was dropped: {type(error).__name__}: {error}"
        return ""


SET_BACK = timedelta(seconds=1)
"""A time server moves a clock by less."""


class Emitter:
    """Numbers and times events and puts them on a bus; the only source of a run's events.

    An alarm says so if the machine's clock was set back: then times of day are out of order, while
    durations are not affected.
    """

    def __init__(self, bus: Bus, clock: Clock, first_seq: int = 0) -> None:
        self._bus = bus
        self._clock = clock
        self._latest = clock.utc()
        self._stamp = EventStamp(clock, first_seq)

    def __call__(self, kind: type[Event], **fields: Any) -> None:
        """Emit one event; an Alarm follows for each guarded sink that failed on it."""
        self._look_at_clock()
        for text in self._bus.emit(self._stamp(kind, **fields)):
            self(Alarm, source="event sink", text=text)

    def _look_at_clock(self) -> None:
        now, latest = self._clock.utc(), self._latest
        self._latest = now
        if latest - now > SET_BACK:
            was = f"the clock was set back from {utc_text(latest)} to {utc_text(now)}"
            self(Alarm, source="clock", text=f"{was}; durations are measured by another one")


class EventStamp:
    """Makes events with consecutive sequence numbers and the clock's time."""

    def __init__(self, clock: Clock, first_seq: int = 0) -> None:
        self._clock = clock
        self._seq = itertools.count(first_seq)

    def __call__(self, kind: type[_E], **fields: Any) -> _E:
        """Return an event of that kind, stamped."""
        return kind(
            seq=next(self._seq),
            monotonic_s=self._clock.monotonic_s(),
            utc=utc_text(self._clock.utc()),
            **fields,
        )


def _name(sink: EventSink) -> str:
    return getattr(sink, "__name__", type(sink).__name__)
