"""Base of drivers whose instrument is set up and made safe by commands."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from rigrunner.api import DeviceLostError, DeviceTimeoutError, Driver
from rigrunner.api.cleanup import do_all

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from rigrunner.api import Identity

_T = TypeVar("_T")


class CommandedDriver(Driver):
    """A Driver whose instrument is set up, and made safe, by commands.

    Give it `begin_talk`, `set_up` and `send`. After a connection that was lost, or an answer that
    did not come, nobody knows whether the instrument was off meanwhile: it is identified and set up
    again before anything else is asked of it. To be made safe it need not be set up.
    """

    safe_commands: Sequence[str] = ()
    _state_unknown = False
    _skips_setup = False

    def begin_talk(self, timeout_s: float) -> Identity:
        """Open the connection and return the identity; raise a DeviceError."""
        raise NotImplementedError

    def set_up(self) -> None:
        """Set the instrument up as the station defines; raise a DeviceError."""
        raise NotImplementedError

    def send(self, command: str) -> None:
        """Send the instrument a command; raise a DeviceError."""
        raise NotImplementedError

    def open(self, timeout_s: float) -> Identity:
        """Open the connection, identify the instrument, and set it up."""
        making_safe = self._skips_setup
        with self.without_setup():
            identity = self.begin_talk(timeout_s)
            if not making_safe:
                self.set_up()
        # Made safe only: before anything is measured it is still to be set up.
        self._state_unknown = making_safe
        return identity

    def exchange(self, request: str, perform: Callable[[], _T]) -> _T:
        """Do one exchange, with an instrument that is set up."""
        if self._state_unknown and not self._skips_setup:
            self.reconnect()
        try:
            return super().exchange(request, perform)
        except (DeviceLostError, DeviceTimeoutError):
            self._state_unknown = True
            raise

    def make_safe(self) -> Mapping[str, float]:
        """Bring all drives to their safe values and then send the safe commands, whatever fails."""
        read_back: dict[str, float] = {}
        # Taken here: within the lambda below, super() would find no object.
        make_safe = super().make_safe
        with self.without_setup():
            do_all(
                lambda: read_back.update(make_safe()),
                *(partial(self._send_safe, command) for command in self.safe_commands),
            )
        return read_back

    @contextmanager
    def without_setup(self) -> Iterator[None]:
        """Talk to the instrument without setting it up first."""
        previous, self._skips_setup = self._skips_setup, True
        try:
            yield
        finally:
            self._skips_setup = previous

    def _send_safe(self, command: str) -> None:
        self._need_connection_to_make_safe()
        try:
            self.send(command)
        except DeviceLostError:
            self.reconnect()
            self.send(command)


class OneAtATime:
    """Lets one thread talk at a time: one that makes safe may come while another one waits."""

    def __init__(self) -> None:
        self._lock = threading.RLock()

    @contextmanager
    def alone(self, patience_s: float) -> Iterator[None]:
        """Wait for exclusive access; raise DeviceTimeoutError if that takes too long."""
        if not self._lock.acquire(timeout=patience_s):
            raise DeviceTimeoutError("an earlier exchange with the instrument still hangs")
        try:
            yield
        finally:
            self._lock.release()
