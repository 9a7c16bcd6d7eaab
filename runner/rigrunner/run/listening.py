"""Lets a station's listeners have the events of a run without holding it up."""

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
"""Events; of samples one counts as many as it has units of this size."""
UNIT_BYTES = 2560
"""So that what waits for a listener never takes more than 256 MB, however fast the rig samples."""
PATIENCE_S = 0.5
"""How long the run waits, in all, for a listener that does not keep up; then that one is dropped.
One that is a little too slow would hold the run to its pace, were it waited for anew each time."""
LAST_WORDS_S = 5.0
"""How long a listener may take for what is left when the run is over."""


class Detached:
    """Hands events to a listener in a thread of its own: one that hangs stops nothing else.

    What it raises, the next call raises; so does one for which too many events wait.
    """

    def __init__(self, name: str, sink: EventSink, most_waiting: int = MOST_WAITING) -> None:
        self.__name__ = name
        self._sink = sink
        self._waiting = _Weighed(most_waiting)
        self._failure: Exception | None = None
        self._given_up = False
        self._patience_s = PATIENCE_S
        self._thread = threading.Thread(target=self._work, name=f"listener {name}", daemon=True)
        self._thread.start()

    def __call__(self, event: Event) -> None:
        """Take one event and return, at the latest after what is left of PATIENCE_S."""
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

    def close(self) -> None:
        """Let it have what is waiting, and let go of it."""
        try:
            self._waiting.put_nowait(None)
        except Full:  # it hangs, or has failed
            self._given_up = True
            return
        self._thread.join(LAST_WORDS_S)

    def _work(self) -> None:
        while not self._given_up and (event := self._waiting.get()) is not None:
            try:
                self._sink(event)
            except Exception as error:  # noqa: BLE001  (a stranger's may raise anything)
                self._failure = error
                break
            except BaseException as error:  # noqa: BLE001  (it would end this thread alone, unseen)
                self._failure = RuntimeError(f"it raised {type(error).__name__}({error})")
                break
        if isinstance(self._sink, ClosingSink):
            with suppress(Exception):  # nobody hears it any more
                self._sink.close()


class _Weighed(Queue["Event | None"]):
    """A queue that is full by the weight of what waits, not by its number."""

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
    """The listeners of a station, and what they alone are told."""

    sinks: tuple[Detached, ...]
    stamp: EventStamp

    def tell(self, kind: type[Event], **fields: Any) -> None:
        """Tell them of what is not on record; who has failed is found by the next event."""
        event = self.stamp(kind, **fields)
        for each in self.sinks:
            with suppress(Exception):
                each(event)


@contextmanager
def listeners_of(planned: Planned) -> Iterator[Listeners]:
    """Give the listeners that the station names; raise PluginError for one that refuses."""
    registry, named = planned.registry, planned.station.model.listeners
    sinks = [
        (each.plugin, registry.make("event_sink", each.plugin, each.settings)) for each in named
    ]
    with ExitStack() as held:
        detached = tuple(Detached(name, sink) for name, sink in sinks)
        for each in detached:
            held.callback(each.close)
        yield Listeners(detached, EventStamp(planned.clock))
