"""Answers of receivers, limited in time and size.

The libraries bound each read, but not how many there are: an answer that never ends would take a
core, or all memory, of the process that runs the test.
"""

from __future__ import annotations

import errno
import io
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import socket

    from typing_extensions import Buffer

MOST_BYTES = 64 * 1024
"""Of one answer: a receiver needs some hundred to take a message or to refuse it."""


class Answer(io.RawIOBase):
    """The answers that come on a socket, each within the time-out of the socket.

    What reads them raises OSError where an answer takes longer, or has more than MOST_BYTES.
    """

    def __init__(self, sock: socket.socket) -> None:
        super().__init__()
        self._sock = sock
        self._timeout_s = sock.gettimeout()
        self.begin()

    def begin(self) -> None:
        """Expect another answer from now on."""
        self._left = MOST_BYTES
        self._end_s = time.monotonic() + (self._timeout_s or 0.0)

    def readable(self) -> bool:
        """Return True: it is there to be read."""
        return True

    def readinto(self, buffer: Buffer) -> int:
        """Read what has come; return 0 where the connection is closed."""
        left_s = self._end_s - time.monotonic()
        if left_s <= 0 or self._left <= 0:
            raise OSError(errno.EMSGSIZE, "the answer does not end")
        self._sock.settimeout(left_s)
        try:
            count = self._sock.recv_into(buffer)
        finally:
            self._sock.settimeout(self._timeout_s)
        self._left -= count
        return count
