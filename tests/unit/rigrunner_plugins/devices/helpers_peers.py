"""The other end of a wire, in a thread: it sends the bytes that a test states."""

from __future__ import annotations

import os
import socket
import threading
import time
import tty
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

HANG_UP = b"(hangs up)"
"""As an answer: the connection is closed."""
SILENCE = b""


class Script:
    """Answers messages in the scripted order; on any other it hangs up, and keeps it."""

    def __init__(self, lines: Sequence[tuple[bytes, bytes]]) -> None:
        self.left = list(lines)
        self.unexpected: list[bytes] = []

    def __call__(self, received: bytes) -> tuple[int, bytes]:
        """Return how many of the bytes were taken, and the answer to them."""
        if not self.left or not self.left[0][0].startswith(received[: len(self.left[0][0])]):
            self.unexpected.append(received)
            return len(received), HANG_UP
        if len(received) < len(self.left[0][0]):
            return 0, SILENCE
        message, answer = self.left.pop(0)
        return len(message), answer


class Lines:
    """Answers each line by a function; keeps the lines."""

    def __init__(self, answer: Callable[[str], bytes], ending: bytes = b"\n") -> None:
        self.answer = answer
        self.ending = ending
        self.heard: list[str] = []

    def last(self, expected: str) -> str:
        """Return the last line; a command without an answer may take a moment to arrive."""
        until_s = time.monotonic() + 30.0
        while self.heard[-1:] != [expected] and time.monotonic() < until_s:
            time.sleep(0.01)
        return self.heard[-1]

    def __call__(self, received: bytes) -> tuple[int, bytes]:
        line, ending, _ = received.partition(self.ending)
        if not ending:
            return 0, SILENCE
        self.heard.append(line.decode())
        return len(line) + len(ending), self.answer(line.decode())


Talk = "Callable[[bytes], tuple[int, bytes]]"


class SocketPeer:
    """A TCP server on a free port of this machine that talks to one client after another."""

    def __init__(self, talk: Talk) -> None:
        self._talk = talk
        self._server = socket.create_server(("127.0.0.1", 0))
        self._clients: list[socket.socket] = []
        self.connections = 0
        threading.Thread(target=self._serve, daemon=True).start()

    @property
    def port(self) -> int:
        return self._server.getsockname()[1]

    @property
    def resource(self) -> str:
        return f"TCPIP::127.0.0.1::{self.port}::SOCKET"

    def hang_up(self) -> None:
        """Close the connection, as if a cable is pulled or an instrument restarts."""
        while self._clients:
            client = self._clients.pop()
            with suppress(OSError):
                client.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Stop: clients can no longer connect."""
        with suppress(OSError):
            self._server.shutdown(socket.SHUT_RDWR)
        self._server.close()
        self.hang_up()

    def _serve(self) -> None:
        with suppress(OSError):
            while True:
                client, _ = self._server.accept()
                self.connections += 1
                self._clients.append(client)
                threading.Thread(target=self._converse, args=(client,), daemon=True).start()

    def _converse(self, client: socket.socket) -> None:
        with client, suppress(OSError):
            received = b""
            while part := client.recv(65536):
                received += part
                while received:
                    taken, answer = self._talk(received)
                    received = received[taken:]
                    if answer == HANG_UP:
                        return
                    client.sendall(answer)
                    if not taken:
                        break


class SerialPeer:
    """The far end of a serial line: a pseudo-terminal, whose near end is a port to open."""

    def __init__(self, talk: Talk | None = None) -> None:
        self._far, near = os.openpty()
        tty.setraw(near)
        self.port = os.ttyname(near)
        self._near = near
        if talk is not None:
            self.talk_to(talk)

    def talk_to(self, talk: Talk) -> None:
        """Answer received messages by `talk`."""
        self._talk = talk
        threading.Thread(target=self._converse, daemon=True).start()

    @property
    def resource(self) -> str:
        return f"ASRL{self.port}::INSTR"

    def say(self, data: bytes) -> None:
        os.write(self._far, data)

    def unplug(self) -> None:
        """Take the far end away: reading the near one then fails, as with a pulled adapter."""
        for end in ("_far", "_near"):
            descriptor = getattr(self, end)
            setattr(self, end, -1)
            if descriptor >= 0:
                os.close(descriptor)

    close = unplug

    def _converse(self) -> None:
        received = b""
        with suppress(OSError):
            while part := os.read(self._far, 65536):
                received += part
                while received:
                    taken, answer = self._talk(received)
                    received = received[taken:]
                    if answer == HANG_UP:
                        self.unplug()
                        return
                    os.write(self._far, answer)
                    if not taken:
                        break


@contextmanager
def peer(kind: type[SocketPeer | SerialPeer], talk: Talk) -> Iterator[SocketPeer]:
    """Yield a peer and close it."""
    device = kind(talk)
    try:
        yield device
    finally:
        device.close()
