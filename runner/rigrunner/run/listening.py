"""Passes the events of a run to the listeners of a station without delaying it."""

from __future__ import annotations

import threading
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from queue import Full, Queue
from time import monotonic
from typing import TYPE_CHECKING, Any

from rigrunner.api.events import ClosingSink, Samples
from rigrunner.bus import EventStamp

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.events import Event, EventSink
    from rigrunner.run.prepare import Planned

MOST_WAITING = 100_000
"""Number of events; samples count as several, by this size."""
UNIT_BYTES = 2560
"""Limits the memory of a listener to 256 MB, however fast the rig samples."""
PATIENCE_S = 0.5
"""Total time that the run waits for a slow listener, which is then dropped. A new wait each time
would slow the run down to its pace."""
LAST_WORDS_S = 5.0
"""Time for a listener to finish after the run."""


class Detached:
    """Passes events to a listener in its own thread: one that hangs blocks nothing else.

    Its exceptions are raised by the next call; so is an error if too many events wait.
    """

    def __init__(self, name: str, sink: EventSink, most_waiting: int = MOST_WAITING) -> None:
        self.__name__ = name
        self._sink = sink
        self._waiting = _Weighed(most_waiting)
        self._failure: Exception | None = None
        self._given_up = self._ends = False
        self._patience_s = PATIENCE_S
        # A daemon: a listener that hangs must not keep the program from ending.
        self._thread = threading.Thread(target=self._work, name=f"listener {name}", daemon=True)
        self._thread.start()

    def __call__(self, event: Event) -> None:
        """Add an event, waiting at most for the rest of PATIENCE_S."""
        if self._failure is not None:
            raise self._failure
        try:
            self._waiting.put_nowait(event)
        except Full:
            self._wait_for_room(event)

    def _wait_for_room(self, event: Event) -> None:
        began_s = monotonic()
        try:
            self._waiting.put(event, timeout=self._patience_s)
        except Full:
            self._given_up = True
            raise TimeoutError("it does not keep up with the run") from None
        self._patience_s = max(self._patience_s - (monotonic() - began_s), 0.0)

    def end(self) -> None:
        """Let it take the waiting events, and release it, without waiting."""
        self._ends = True
        try:
            self._waiting.put_nowait(None)
        except Full:  # it hangs, or has failed
            self._given_up = True

    def close(self) -> None:
        """Let it take the waiting events, and release it."""
        if not self._ends:
            self.end()
        if not self._given_up:
            self._thread.join(LAST_WORDS_S)

    def _work(self) -> None:
        while not self._given_up and (event := self._waiting.get()) is not None:
            try:
                self._sink(event)
            except Exception as error:  # noqa: BLE001  (a plugin may raise anything)
                self._failure = error
                break
            except BaseException as error:  # noqa: BLE001  (it would end this thread alone, unseen)
                self._failure = RuntimeError(f"it raised {type(error).__name__}({error})")
                break
        if isinstance(self._sink, ClosingSink):
            with suppress(Exception):  # there is no receiver any more
                self._sink.close()


class _Weighed(Queue["Event | None"]):
    """A queue that is full by the weight of its items, not by their number."""

    # These four are what `queue.Queue` has for other kinds of queues.
    def _init(self, maxsize: int) -> None:
        super()._init(maxsize)
        self._weight = 0

    def _qsize(self) -> int:
        return self._weight

    def _put(self, item: Event | None) -> None:
        super()._put(item)
        self._weight += _weight(item)

    def _get(self) -> Event | None:
        item = super()._get()
        self._weight -= _weight(item)
        return item


def _weight(event: Event | None) -> int:
    if not isinstance(event, Samples):
        return 1
    return 1 + sum(values.nbytes for values in event.block.channels.values()) // UNIT_BYTES


@dataclass(frozen=True)
class Listeners:
    """The listeners of a station, and the events for them alone."""

    sinks: tuple[Detached, ...]
    stamp: EventStamp

    def send(self, kind: type[Event], **fields: Any) -> None:
        """Send them an event that is not recorded; failures appear with the next event."""
        event = self.stamp(kind, **fields)
        for sink in self.sinks:
            with suppress(Exception):
                sink(event)


@contextmanager
def listeners_of(planned: Planned) -> Iterator[Listeners]:
    """Yield the listeners of a station; raise PluginError for one that fails."""
    registry, entries = planned.registry, planned.station.model.listeners
    sinks = [(e.plugin, registry.make("event_sink", e.plugin, e.settings)) for e in entries]
    with ExitStack() as stack:
        detached = tuple(Detached(name, sink) for name, sink in sinks)
        for listener in detached:
            stack.callback(listener.close)
        try:
            yield Listeners(detached, EventStamp(planned.clock))
        finally:
            # All at once: only the slowest is waited for.
            for listener in detached:
                listener.end()
