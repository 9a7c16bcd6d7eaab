"""Modbus peers: one that plays a script of bytes, and one that serves simulated units."""

from __future__ import annotations

import os
import socket
import threading
import tty
from contextlib import contextmanager, suppress
from pathlib import Path

from rigrunner.api.devices import DeviceContext
from rigrunner.clock import WallClock
from rigrunner.registry import load_registry

HANG_UP = object()
"""In place of an answer: the peer closes the connection."""
SILENCE = b""
"""In place of an answer: none."""

FREQUENCY = {
    "holding": 1,
    "scale": 0.01,
    "unit": "Hz",
    "min": "0 Hz",
    "max": "35 Hz",
    "safe": "0 Hz",
    "tolerance": "0.05 Hz",
    "rate": "200 Hz/s",
    "settle": "1 s",
    "sets_cycle_frequency": "yes",
    "read_back": {"input": 1, "scale": 0.01, "unit": "Hz"},
    "run": [{"holding": 0, "value": 1}],
    "stop": [{"holding": 0, "value": 0}],
}
"""The drive of the simulated inverter."""


def crc(frame: bytes) -> bytes:
    """Return the CRC of a serial frame, low byte first (MODBUS over Serial Line V1.02, 6.2.2)."""
    register = 0xFFFF
    for byte in frame:
        register ^= byte
        for _ in range(8):
            register = register >> 1 ^ 0xA001 if register & 1 else register >> 1
    return register.to_bytes(2, "little")


def mbap(transaction: int, unit: int, pdu: str) -> bytes:
    """Return a PDU, in hex, in a TCP frame (Messaging on TCP/IP V1.0b, clause 3.1.3)."""
    body = bytes.fromhex(pdu)
    head = [transaction, 0, len(body) + 1]
    return b"".join(word.to_bytes(2, "big") for word in head) + bytes([unit]) + body


def rtu(unit: int, pdu: str) -> bytes:
    """Return a PDU, in hex, in a serial frame."""
    frame = bytes([unit]) + bytes.fromhex(pdu)
    return frame + crc(frame)


class Scripted:
    """Waits for each request of the script in turn and gives its answer; keeps what it heard."""

    def __init__(self, script, receive, send, hang_up):
        self.script, self.heard = list(script), []
        self._receive, self._send, self._hang_up = receive, send, hang_up

    @property
    def asked(self):
        return [request for request, _ in self.script]

    def play(self):
        for request, answer in self.script:
            got = b""
            while len(got) < len(request):
                more = self._receive(len(request) - len(got))
                if not more:
                    return
                got += more
            self.heard.append(got)
            if answer is HANG_UP:
                self._hang_up()
                return
            if answer:
                self._send(answer)


@contextmanager
def tcp_peer(script, connections=1):
    """Serve a script on loopback, to one connection after the other; give it and the settings."""
    listener = socket.create_server(("127.0.0.1", 0))
    played = Scripted(script, None, None, None)

    def serve():
        left = list(script)
        for _ in range(connections):
            try:
                connection, _ = listener.accept()
            except OSError:
                return
            with connection:
                one = Scripted(left, connection.recv, connection.sendall, connection.close)
                with suppress(OSError):
                    one.play()
                    connection.recv(1)  # until the client closes
                played.heard += one.heard
                left = left[len(one.heard) :]

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield played, {"tcp": {"host": "127.0.0.1", "port": listener.getsockname()[1]}}
    finally:
        listener.shutdown(socket.SHUT_RDWR)
        listener.close()
        thread.join(5)


@contextmanager
def rtu_peer(script):
    """Play a script at the other end of a pseudo-terminal; give it and the settings."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    hung_up = threading.Event()
    played = Scripted(script, lambda n: os.read(ours, n), lambda b: os.write(ours, b), hung_up.set)

    def serve():
        with suppress(OSError):
            played.play()
        if hung_up.is_set():
            os.close(ours)

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield played, {"rtu": {"port": os.ttyname(theirs)}}
    finally:
        os.close(theirs)
        thread.join(5)
        if not hung_up.is_set():
            os.close(ours)


def device(settings, clock=None, role="motor"):
    """Return the device as a station would have it."""
    context = DeviceContext(role, clock or WallClock(), Path())
    return load_registry().make_device("modbus", settings, context)
