"""Exchange of lines of text with an instrument, one answer to each request."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Protocol

from rigrunner.api.cleanup import noted_on
from rigrunner.api.errors import (
    DeviceError,
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

_LONGEST = 65536
"""Maximum bytes of a line."""


class Port(Protocol):
    """Transports bytes; errors are OSErrors."""

    def ready(self, within_s: float) -> bool:
        """Return whether data can be received, waiting at most for the given time."""
        ...

    def receive(self) -> bytes:
        """Return the received data; empty if the other end has closed."""
        ...

    def transmit(self, data: bytes, within_s: float) -> None:
        """Send all of the data."""
        ...

    def close(self) -> None:
        """Give the port back; idempotent."""
        ...


class LineLink:
    """Exchanges lines of ASCII text, without their terminator.

    `answer_s` is the time-out of a whole answer. All errors are DeviceErrors. After one the port is
    closed, so that a late answer is never taken for that to another request.
    """

    def __init__(self, name: str, port: Port, terminator: str, answer_s: float) -> None:
        self._name, self._port, self._answer_s = name, port, answer_s
        self._end = terminator.encode("ascii")
        self._failed = False

    def ask(self, request: str) -> str:
        """Send a line and return the answer."""
        with self._given_up_if_it_fails(request):
            self._send(request)
            return self._line(request)

    def tell(self, request: str) -> None:
        """Send a line without an answer."""
        with self._given_up_if_it_fails(request):
            self._send(request)

    def wait_for_silence(self, quiet_s: float) -> None:
        """Discard late answers until nothing has arrived for a time.

        A serial port, unlike a socket, passes them to the next one who opens it. Waits three times
        as long at most.
        """
        until_s = time.monotonic() + 3 * quiet_s
        with self._given_up_if_it_fails("(waiting for silence)"):
            while time.monotonic() < until_s and self._port.ready(quiet_s):
                self._port.receive()

    def close(self) -> None:
        """Close the port; idempotent."""
        self._port.close()

    @contextmanager
    def _given_up_if_it_fails(self, request: str) -> Iterator[None]:
        try:
            yield
        except DeviceError as error:
            self._give_up(error)
            raise
        except TimeoutError as error:
            self._give_up(error)
            raise DeviceTimeoutError(f"{self._name} did not accept '{request}'") from error
        except OSError as error:
            self._give_up(error)
            reason = error.strerror or error
            raise DeviceLostError(f"{self._name} was lost at '{request}': {reason}") from error

    def _give_up(self, error: Exception) -> None:
        self._failed = True
        with noted_on(error, "closing the port"):
            self._port.close()

    def _send(self, request: str) -> None:
        if self._failed:
            raise DeviceLostError(f"{self._name} was abandoned after an earlier failure")
        if self._port.ready(0.0):
            waiting = self._port.receive()
            if not waiting:
                raise DeviceLostError(f"{self._name} closed the connection")
            raise DeviceLostError(
                f"{self._name} sent {waiting[:40]!r} without being asked",
                hint="is it the answer to an earlier command that should have none?",
            )
        self._port.transmit(request.encode("ascii") + self._end, self._answer_s)

    def _line(self, request: str) -> str:
        """Return one complete line, within the time-out from the first byte to the last."""
        until_s = time.monotonic() + self._answer_s
        received = b""
        while not received.endswith(self._end):
            remaining_s = until_s - time.monotonic()
            if remaining_s <= 0 or not self._port.ready(remaining_s):
                within = f"within {self._answer_s:g} s"
                if not received:
                    raise DeviceTimeoutError(f"{self._name} did not answer '{request}' {within}")
                raise DeviceTimeoutError(
                    f"{self._name} answered '{request}' by {received[:40]!r} and no {self._end!r}"
                    f" {within}",
                    hint="does the instrument use this line terminator?",
                )
            more = self._port.receive()
            if not more:
                raise DeviceLostError(f"{self._name} closed the connection at '{request}'")
            received += more
            if len(received) > _LONGEST:
                raise DeviceRejectedError(f"'{request}' was answered by more than {_LONGEST} bytes")
        line = received.removesuffix(self._end)
        # Two lines at once: it is not known which of them is the answer.
        if self._end in line or not line.isascii():
            raise DeviceRejectedError(
                f"'{request}' was answered by {line[:40]!r}, expected one line of text"
            )
        return line.decode("ascii")
