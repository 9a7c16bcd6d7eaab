"""Reads the rig's channels for the screen between recordings."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from rigrunner.api.devices import Readable
from rigrunner.api.errors import RigrunnerError
from rigrunner_panel.process.messages import Values

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rigrunner.api.devices import Device
    from rigrunner.rig import Rig

EVERY_S = 0.1
SHARE = 4
"""Reading takes at most one part in this number plus one of the time; slow devices are read less
often."""
AFTER_FAILURE_S = 5.0
"""Time in s before a device that did not answer is read again."""


class WatchedChannels:
    """Reads every channel of every readable device, at most ten times a second."""

    def __init__(self, send: Callable[[object], None], devices: Mapping[str, Device]) -> None:
        self._send = send
        self._names = {
            role: tuple(channel.name for channel in device.channels)
            for role, device in devices.items()
            if isinstance(device, Readable) and device.channels
        }
        self._due_s = dict.fromkeys(self._names, 0.0)
        self._rig: Rig | None = None

    def look(self, rig: Rig | None = None, busy_s: float = 0.0) -> None:
        """Read the devices that are due; without a rig, those of the last rig.

        `busy_s`: the next look is not before that time.
        """
        self._rig = rig or self._rig
        if self._rig is None:
            return
        for role, names in self._names.items():
            began_s = time.monotonic()
            if began_s < self._due_s[role]:
                continue
            try:
                values = self._rig.read(role, names)
            except RigrunnerError:  # the run itself finds out, where it needs the device
                self._due_s[role] = time.monotonic() + AFTER_FAILURE_S
                continue
            took_s = time.monotonic() - began_s
            pause_s = max(EVERY_S, SHARE * took_s)
            self._due_s[role] = began_s + took_s + pause_s
            self._send(Values(values, time.time(), took_s + max(pause_s, busy_s)))
