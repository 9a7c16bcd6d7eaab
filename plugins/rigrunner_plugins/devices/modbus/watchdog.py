"""Tells an instrument again and again that somebody is there.

It proves that this program lives and the line holds, no more: it runs in a thread of its own.
"""

from __future__ import annotations

import itertools
import threading
from typing import TYPE_CHECKING

from rigrunner.api import DeviceError
from rigrunner_plugins.devices.modbus.grouping import Span

if TYPE_CHECKING:
    from rigrunner_plugins.devices.modbus.line import Line
    from rigrunner_plugins.devices.modbus.settings import Watchdog


class Heartbeat:
    """Beats from `start` to `stop`; where a beat fails the line is closed, with the reason."""

    def __init__(self, watchdog: Watchdog, line: Line) -> None:
        self._watchdog = watchdog
        self._line = line
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._beat, name="modbus watchdog", daemon=True)

    def start(self) -> None:
        """Begin, in a thread of its own."""
        self._thread.start()

    def stop(self) -> None:
        """End; return once the thread has ended."""
        self._ended.set()
        self._thread.join()

    def _beat(self) -> None:
        watchdog = self._watchdog
        beat = Span(watchdog.table, watchdog.address, 1, watchdog.unit_id)
        for value in itertools.cycle(watchdog.write or (None,)):
            try:
                if value is None:
                    self._line.read(beat)
                else:
                    self._line.write(watchdog, [value], multiple=False)
            except DeviceError as error:
                self._line.close(f"the watchdog failed: {error.message}")
                return
            if self._ended.wait(watchdog.every):
                return
