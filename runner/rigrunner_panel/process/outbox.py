"""What the run tells the panel, without ever waiting for it."""

from __future__ import annotations

import threading
from queue import SimpleQueue
from time import monotonic
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.events import Event, Samples, Scanned
from rigrunner_panel.process.channel import ChannelClosedError
from rigrunner_panel.process.news import Curve, Happened

if TYPE_CHECKING:
    from rigrunner_panel.process.channel import Channel

MOST_CURVES = 50
"""Blocks that wait for a panel that does not keep up; more are left out. The file has them all."""
_FLUSH_S = 10.0
_ROWS_EVERY_S = 0.05
"""How often a screen is sent a point of a scan: there may be many thousands in a second."""


class Outbox:
    """Sends from a thread of its own; an event sink. A panel that is gone is not told any more."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._queue: SimpleQueue[object] = SimpleQueue()
        self._curves = 0
        self._row: Scanned | None = None
        self._rows_due_s = 0.0
        self._thread = threading.Thread(target=self._work, name="to the panel", daemon=True)
        self._thread.start()

    def send(self, message: object) -> None:
        """Send a message after those before it."""
        self._queue.put(message)

    def send_unless_behind(self, message: object) -> None:
        """Send what is only of use now, unless the panel has not taken much that was before it."""
        if self._queue.qsize() < MOST_CURVES:
            self.send(message)

    def __call__(self, event: Event) -> None:
        """Send an event of the run; of samples and scans what a screen can show."""
        if isinstance(event, Scanned):
            self._scanned(event)
            return
        if self._row is not None:
            self.send(Happened(self._row))
            self._row = None
        if not isinstance(event, Samples):
            self.send(Happened(event))
        elif self._curves < MOST_CURVES:
            self._curves += 1
            self.send(_curve(event))

    def _scanned(self, row: Scanned) -> None:
        """Send a point now and then, and the last one before whatever follows."""
        now_s = monotonic()
        self._row = row
        if now_s >= self._rows_due_s:
            self.send(Happened(row))
            self._row, self._rows_due_s = None, now_s + _ROWS_EVERY_S

    def close(self) -> None:
        """Send what is left."""
        self._queue.put(None)
        self._thread.join(_FLUSH_S)

    def _work(self) -> None:
        is_heard = True
        while (message := self._queue.get()) is not None:
            if isinstance(message, Curve):
                self._curves -= 1
            if is_heard:
                is_heard = self._sent(message)

    def _sent(self, message: object) -> bool:
        try:
            self._channel.send(message)
        except ChannelClosedError:
            return False
        return True


def _curve(event: Samples) -> Curve:
    block = event.block
    channels = {name: np.asarray(values, np.float32) for name, values in block.channels.items()}
    return Curve(event.recording, block.rate_hz, block.first_sample, event.monotonic_s, channels)
