"""Drives that were set, watched beside each reading: each is to stay where it was set."""

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
"""How often drives are read back during a reading, as the channels of interlocks are."""


class DriveWatch:
    """Reads drives back and ends the run, like an interlock, where one fell away.

    A drive may have been switched off at the device, set by another program, or have failed: what
    is read meanwhile does not belong to its set-point.
    """

    def __init__(self, rig: Rig, emit: Emit) -> None:
        self._rig = rig
        self._emit = emit
        self._now_s = rig.clock.monotonic_s
        self._looked_s = self._now_s()
        self._streaming: list[str] = []

    def look(self) -> None:
        """Check if it is time to."""
        if self._now_s() - self._looked_s >= EVERY_S:
            self.check()

    def check(self) -> None:
        """Read back every drive that was set; raise InterlockError for one that is elsewhere.

        The drives of a device that streams are left out, unless it can be read meanwhile.
        """
        before_s = self._looked_s
        for member, found in self._rig.drives_astray(self._streaming):
            name, latency_s = f"drive {member}", self._now_s() - before_s
            self._emit(
                InterlockTripped,
                source=name,
                interlock=name,
                text=found,
                does="make_safe",
                latency_s=latency_s,
            )
            raise InterlockError(found, by=name, makes_safe=True)
        self._looked_s = self._now_s()

    @contextmanager
    def streaming(self, role: str) -> Iterator[None]:
        """Leave a device alone while it streams, unless it says that it can be read meanwhile."""
        busy = not getattr(self._rig.devices[role], "reads_back_while_streaming", False)
        if busy:
            self._streaming.append(role)
        try:
            yield
        finally:
            if busy:
                self._streaming.remove(role)
