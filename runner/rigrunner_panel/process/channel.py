"""Sends Python objects between two processes of this program over a pair of pipes."""

from __future__ import annotations

import os
import pickle
import sys
import threading
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from typing import IO, Self


class ChannelClosedError(Exception):
    """The process at the other end has ended."""


class Channel:
    """Sends from any thread and receives in one. Both ends are trusted (pickle)."""

    def __init__(self, incoming: IO[bytes], outgoing: IO[bytes]) -> None:
        self._incoming = incoming
        self._outgoing = outgoing
        self._lock = threading.Lock()

    @classmethod
    def on_stdout(cls) -> Self:
        """Return the channel of a child process; what a plugin prints goes to stderr."""
        outgoing = os.fdopen(os.dup(1), "wb")
        os.dup2(2, 1)
        sys.stdout = sys.stderr
        return cls(sys.stdin.buffer, outgoing)

    def send(self, message: object) -> None:
        """Send one object that can be pickled; raise ChannelClosedError."""
        content = pickle.dumps(message, pickle.HIGHEST_PROTOCOL)
        try:
            with self._lock:
                self._outgoing.write(content)
                self._outgoing.flush()
        except (OSError, ValueError) as error:
            raise ChannelClosedError from error

    def receive(self) -> Any:
        """Return the next object; raise ChannelClosedError."""
        try:
            return pickle.load(self._incoming)  # noqa: S301  (from our own process, by its pipe)
        except (EOFError, OSError, ValueError, pickle.UnpicklingError) as error:
            raise ChannelClosedError from error

    def close(self) -> None:
        """Close the sending side; the other end is notified."""
        with self._lock:
            try:
                self._outgoing.close()
            except OSError:
                return
