"""Modbus peers: one that plays a script of bytes, and one that serves simulated units."""

from __future__ import annotations

import asyncio
import os
import select
import socket
import threading
import tty
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from pymodbus.server import ModbusSerialServer

from rigrunner.api.devices import DeviceContext
from rigrunner.clock import WallClock
from rigrunner.registry import load_registry
from rigrunner_plugins.devices.modbus.served.server import sim_device

HANG_UP = object()
"""In place of an answer: the peer closes the connection."""
SILENCE = b""
"""In place of an answer: none."""


@dataclass(frozen=True)
class After:
    """An answer that comes late."""

    event: threading.Event
    """It is waited for."""
    answer: bytes


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
    """Waits for each request of the script in turn and sends its answer; keeps the requests."""

    def __init__(self, script, receive, send, hang_up):
        self.script, self.heard = list(script), []
        self._receive, self._send, self._hang_up = receive, send, hang_up

    @property
    def asked(self):
        return [request for request, _ in self.script]

    def play(self):
        for request, answer in self.script:
            received = b""
            while len(received) < len(request):
                part = self._receive(len(request) - len(received))
                if not part:
                    return
                received += part
            self.heard.append(received)
            if answer is HANG_UP:
                self._hang_up()
                return
            if isinstance(answer, After):
                answer.event.wait(60)
                self._send(answer.answer)
            elif answer:
                self._send(answer)


@contextmanager
def tcp_peer(script, connections=1):
    """Serve a script on loopback, to one connection after another; yield it and the settings."""
    listener = socket.create_server(("127.0.0.1", 0))
    peer = Scripted(script, None, None, None)

    def serve():
        left = list(script)
        for _ in range(connections):
            try:
                connection, _ = listener.accept()
            except OSError:
                return
            with connection:
                scripted = Scripted(left, connection.recv, connection.sendall, connection.close)
                with suppress(OSError):
                    scripted.play()
                    connection.recv(1)  # until the client closes
                peer.heard += scripted.heard
                left = left[len(scripted.heard) :]

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield peer, {"tcp": {"host": "127.0.0.1", "port": listener.getsockname()[1]}}
    finally:
        listener.shutdown(socket.SHUT_RDWR)
        listener.close()
        thread.join(5)


@contextmanager
def rtu_peer(script):
    """Play a script at the other end of a pseudo-terminal; yield it and the settings."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    hung_up = threading.Event()
    peer = Scripted(script, lambda n: os.read(ours, n), lambda b: os.write(ours, b), hung_up.set)

    def serve():
        with suppress(OSError):
            peer.play()
        if hung_up.is_set():
            os.close(ours)

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield peer, {"rtu": {"port": os.ttyname(theirs)}}
    finally:
        os.close(theirs)
        thread.join(5)
        if not hung_up.is_set():
            os.close(ours)


def device(settings, clock=None, role="motor"):
    """Return the device as a station would make it."""
    context = DeviceContext(role, clock or WallClock(), Path())
    return load_registry().make_device("modbus", settings, context)


@contextmanager
def modbus_line(unit):
    """Serve a unit with pymodbus' serial server over two pseudo-terminals; yield the port."""
    (ours, port), (theirs, far) = os.openpty(), os.openpty()
    for terminal in (port, far):
        tty.setraw(terminal)
    ended = threading.Event()
    wires = [
        threading.Thread(target=_carry, args=ends, daemon=True)
        for ends in ((ours, theirs, ended), (theirs, ours, ended))
    ]
    loop = asyncio.new_event_loop()
    serving = threading.Thread(target=_serve_line, args=(loop, unit, far), daemon=True)
    for thread in (*wires, serving):
        thread.start()
    try:
        yield os.ttyname(port)
    finally:
        ended.set()
        loop.call_soon_threadsafe(loop.stop)
        for thread in (*wires, serving):
            thread.join(5)
        for handle in (ours, theirs, port, far):
            os.close(handle)


def _carry(source, sink, ended):
    while not ended.is_set():
        if select.select([source], [], [], 0.05)[0]:
            os.write(sink, os.read(source, 4096))


def _serve_line(loop, unit, far):
    asyncio.set_event_loop(loop)

    async def start():
        server = ModbusSerialServer(sim_device(unit), port=os.ttyname(far), baudrate=115200)
        await server.serve_forever(background=True)
        return server

    server = loop.run_until_complete(start())
    loop.run_forever()
    loop.run_until_complete(server.shutdown())
    loop.close()


class Cable:
    """A TCP connection to a server on loopback that can be closed or interrupted."""

    def __init__(self, port):
        self._far = port
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self._open = []
        self._swallows = False
        self._accepting = threading.Thread(target=self._accept, daemon=True)
        self._accepting.start()

    def swallow(self):
        """Silently let nothing through any more, like a pulled cable."""
        self._swallows = True

    def drop(self):
        """Close all connections, as a power cut does; new ones are accepted."""
        while self._open:
            end = self._open.pop()
            with suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            end.close()

    def close(self):
        with suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._accepting.join()  # a connection that it has just accepted is dropped too
        self.drop()

    def _accept(self):
        with suppress(OSError):
            while True:
                near, _ = self._listener.accept()
                self._open.append(near)
                far = socket.create_connection(("127.0.0.1", self._far))
                self._open.append(far)
                for source, sink in ((near, far), (far, near)):
                    threading.Thread(target=self._forward, args=(source, sink), daemon=True).start()

    def _forward(self, source, sink):
        with suppress(OSError):
            while data := source.recv(4096):
                if not self._swallows:
                    sink.sendall(data)
            sink.shutdown(socket.SHUT_RDWR)
