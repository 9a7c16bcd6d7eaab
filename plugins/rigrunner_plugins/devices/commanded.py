"""What drivers share whose instrument is made safe by commands too, and which one thread uses."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rigrunner.api.driver import Driver
from rigrunner.api.errors import DeviceError, DeviceLostError, DeviceTimeoutError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence


class CommandedDriver(Driver):
    """A Driver that sends commands once its drives are safe; give it `send`."""

    safe_commands: Sequence[str] = ()

    def send(self, command: str) -> None:
        """Have the instrument do something; raise a DeviceError."""
        raise NotImplementedError

    def make_safe(self) -> Mapping[str, float]:
        """Bring all drives to their safe values and then send the safe commands."""
        try:
            read_back = super().make_safe()
        except DeviceError as error:
            try:
                self._send_safe_commands()
            except DeviceError as second:
                error.add_note(str(second))
            raise
        self._send_safe_commands()
        return read_back

    def _send_safe_commands(self) -> None:
        for command in self.safe_commands:
            try:
                self.send(command)
            except DeviceLostError:
                if self._timeout_s is None:  # it was never connected: nothing of it is known
                    raise
                self.close()
                self.connect(self._timeout_s)
                self.send(command)


class OneAtATime:
    """Lets one thread talk at a time: one that makes safe may come while another one waits."""

    def __init__(self) -> None:
        self._lock = threading.RLock()

    @contextmanager
    def alone(self, patience_s: float) -> Iterator[None]:
        """Wait until nobody else talks; raise DeviceTimeoutError if that takes too long."""
        if not self._lock.acquire(timeout=patience_s):
            raise DeviceTimeoutError("an earlier exchange with the instrument still hangs")
        try:
            yield
        finally:
            self._lock.release()
