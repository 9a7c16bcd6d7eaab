"""Monitors drives during readings: each must stay at its set-point."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from rigrunner.api.events import InterlockTripped
from rigrunner.engine.interlocks import InterlockError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.bus import Emit
    from rigrunner.rig import Rig

EVERY_S = 0.1
"""Interval of read-backs during a reading, the same as for the channels of interlocks."""


class DriveWatch:
    """Reads drives back and ends the run, as an interlock does, if one left its set-point.

    A drive may have been switched off at the device, set by another program, or have failed:
    readings then do not belong to its set-point.
    """

    def __init__(self, rig: Rig, emit: Emit) -> None:
        self._rig = rig
        self._emit = emit
        self._now_s = rig.clock.monotonic_s
        self._checked_s = self._now_s()
        self._streaming: list[str] = []

    def look(self) -> None:
        """Check if the interval has passed."""
        if self._now_s() - self._checked_s >= EVERY_S:
            self.check()

    def check(self) -> None:
        """Read back every drive that was set; raise InterlockError for a deviation.

        Skips the drives of a device that streams, unless it can be read meanwhile.
        """
        # The drive may have left its set-point right after the last check: see `latency_s`.
        checked_s = self._checked_s
        # The first deviation ends the run: further drives are not checked.
        for member, deviation in self._rig.deviating_drives(self._streaming):
            name, latency_s = f"drive {member}", self._now_s() - checked_s
            self._emit(
                InterlockTripped,
                source=name,
                interlock=name,
                text=deviation,
                does="make_safe",
                latency_s=latency_s,
            )
            raise InterlockError(deviation, by=name, makes_safe=True)
        self._checked_s = self._now_s()

    @contextmanager
    def streaming(self, role: str) -> Iterator[None]:
        """Skip a device while it streams, unless it can be read meanwhile."""
        # An instrument that is read while it acquires may lose samples: its driver has to allow it.
        busy = not getattr(self._rig.devices[role], "reads_back_while_streaming", False)
        if busy:
            self._streaming.append(role)
        try:
            yield
        finally:
            if busy:
                self._streaming.remove(role)
