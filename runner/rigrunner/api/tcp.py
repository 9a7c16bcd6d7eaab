"""Lines of text over a TCP socket, one asked and one answered."""

from __future__ import annotations

import select
import socket
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rigrunner.api.errors import (
    DeviceError,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

_LONGEST = 65536
"""Bytes of a line: more than that is no answer."""


class TcpLines:
    """A connection to `host:port` that carries lines of ASCII text, without their terminator.

    `connect_s` is how long connecting may take, `answer_s` how long a whole answer. All that fails
    is a DeviceError. After that it is closed, so that an answer which comes late is
    never taken for that to another question.
    """

    def __init__(self, address: str, terminator: str, connect_s: float, answer_s: float) -> None:
        self._address, self._timeout_s = address, answer_s
        self._end = terminator.encode("ascii")
        host, _, port = address.rpartition(":")
        try:
            self._socket = socket.create_connection((host.strip("[]"), int(port)), connect_s)
        except TimeoutError as error:
            raise DeviceTimeoutError(
                f"{address} did not take the connection within {connect_s:g} s",
                hint="is it switched on, and on this network?",
            ) from error
        except OSError as error:
            raise DeviceNotFoundError(
                f"{address} cannot be reached: {error.strerror or error}",
                hint="is it switched on, is the address right, does another program hold it?",
            ) from error
        self._failed = False

    def ask(self, request: str) -> str:
        """Send a line and return the one line that answers it."""
        with self._given_up_if_it_fails(request):
            self._send(request)
            return self._line(request)

    def tell(self, request: str) -> None:
        """Send a line that is not answered."""
        with self._given_up_if_it_fails(request):
            self._send(request)

    def close(self) -> None:
        """Give the connection back; idempotent."""
        self._socket.close()

    @contextmanager
    def _given_up_if_it_fails(self, request: str) -> Iterator[None]:
        try:
            yield
        except DeviceError:
            self._give_up()
            raise
        except TimeoutError as error:
            self._give_up()
            raise DeviceTimeoutError(f"{self._address} did not take '{request}'") from error
        except OSError as error:
            self._give_up()
            reason = error.strerror or error
            raise DeviceLostError(f"{self._address} was lost at '{request}': {reason}") from error

    def _give_up(self) -> None:
        self._failed = True
        self._socket.close()

    def _send(self, request: str) -> None:
        if self._failed:
            raise DeviceLostError(f"{self._address} was given up after an earlier failure")
        if select.select([self._socket], [], [], 0)[0]:
            self._refuse_what_was_not_asked_for()
        self._socket.settimeout(self._timeout_s)
        self._socket.sendall(request.encode("ascii") + self._end)

    def _refuse_what_was_not_asked_for(self) -> None:
        waiting = self._socket.recv(_LONGEST)
        if not waiting:
            raise DeviceLostError(f"{self._address} closed the connection")
        raise DeviceLostError(
            f"{self._address} sent {waiting[:40]!r} without being asked",
            hint="an answer to an earlier line: does a line that is told have one?",
        )

    def _line(self, request: str) -> str:
        """Return one whole line, within the time-out from the first byte to the last."""
        until_s = time.monotonic() + self._timeout_s
        got = b""
        while not got.endswith(self._end):
            remaining_s = until_s - time.monotonic()
            if remaining_s <= 0 or not select.select([self._socket], [], [], remaining_s)[0]:
                raise self._unfinished(request, got)
            more = self._socket.recv(_LONGEST)
            if not more:
                raise DeviceLostError(f"{self._address} closed the connection at '{request}'")
            got += more
            if len(got) > _LONGEST:
                raise DeviceRejectedError(f"'{request}' was answered by more than {_LONGEST} bytes")
        line = got.removesuffix(self._end)
        if self._end in line or not line.isascii():
            raise DeviceRejectedError(
                f"'{request}' was answered by {line[:40]!r}, needed is one line of text"
            )
        return line.decode("ascii")

    def _unfinished(self, request: str, got: bytes) -> DeviceTimeoutError:
        if not got:
            return DeviceTimeoutError(
                f"{self._address} did not answer '{request}' within {self._timeout_s:g} s"
            )
        return DeviceTimeoutError(
            f"{self._address} answered '{request}' by {got[:40]!r}"
            f" and no {self._end!r} within {self._timeout_s:g} s",
            hint="is it the terminator that the instrument is set to?",
        )
