"""A peer on loopback that answers lines of bytes by a script."""

from __future__ import annotations

import socket
import threading
import time
from contextlib import contextmanager, suppress

PAUSE_S = 0.05
"""Between two pieces of an answer."""
HANG_UP = object()
"""In place of an answer: the peer closes the connection."""


class ScriptedPeer:
    """Answers each line of its script, and remembers all lines that it received.

    `script` maps a line, as bytes with its terminator, to the bytes that answer it; a tuple of
    bytes is sent piece by piece, and an event in it is waited for.
    """

    def __init__(self, script, terminator=b"\n"):
        self.script = script
        self.heard = []
        self._terminator = terminator
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"
        self._open = []
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def close(self):
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        for connection in self._open:
            connection.close()
        self._thread.join(5)

    def _serve(self):
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            self._open.append(connection)
            with suppress(OSError):  # the driver or the test has closed the connection
                self._talk(connection)

    def _talk(self, connection):
        received = b""
        while True:
            data = connection.recv(4096)
            if not data:
                connection.close()
                return
            received += data
            while self._terminator in received:
                line, _, received = received.partition(self._terminator)
                self.heard.append(line + self._terminator)
                answer = self.script.get(line + self._terminator, b"")
                if answer is HANG_UP:
                    connection.shutdown(socket.SHUT_RDWR)
                    connection.close()
                    return
                for part in answer if isinstance(answer, tuple) else (answer,):
                    if isinstance(part, threading.Event):
                        part.wait(60)
                    else:
                        connection.sendall(part)
                        time.sleep(PAUSE_S if isinstance(answer, tuple) else 0)


@contextmanager
def peer(script, terminator=b"\n"):
    """Serve a script on loopback; give the peer."""
    scripted = ScriptedPeer(script, terminator)
    try:
        yield scripted
    finally:
        scripted.close()
