"""Checks on recovery: after a failed exchange, a late answer, or a dropped connection."""

from __future__ import annotations

import socket
import threading
from collections import defaultdict
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from rigrunner.api.errors import DeviceError, DeviceLostError, DeviceTimeoutError
from rigrunner.api.lines import LineDriver
from rigrunner.api.settings import MadeOfOthers
from rigrunner_testing.check import Nonconformity, applies, check, demand
from rigrunner_testing.device.doing import names, reader, safely
from rigrunner_testing.device.failures import FaultyWire

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.devices import Device
    from rigrunner_testing.device.subject import DeviceSubject

TIMEOUT_S = 1.0
LATE_S = 3 * TIMEOUT_S
"""When an answer comes whose question was given up."""
TRIES = 3
"""Readings after a failure: the second and third would show an answer that is one behind."""


@check(
    moves=True,
    fix="connect again before the next call, and identify; `Driver` does: see `reconnects_after`",
    needs=("exchanges_go_over_the_wire",),
)
def recovers_after_a_failure(subject: DeviceSubject) -> None:
    """After a lost or late answer the next call succeeds, with the answer to its own question."""
    applies(subject.record.wired, "its record does not say that it is wired")
    made_of_others = issubclass(subject.record.settings_model, MadeOfOthers)
    applies(not made_of_others, "the exchanges are those of the devices that it is made of")
    wire = FaultyWire()
    with subject.connected(wire=wire) as device:
        for failure in (DeviceTimeoutError, DeviceLostError):
            wire.fails_at, wire.failure = wire.exchanges, failure
            _reads_again(device, f"a {failure.__name__} in an exchange")
            wire.fails_at = -1
    driver = subject.make()
    if isinstance(driver, LineDriver):
        _recovers_over_a_socket(subject, driver)


def _reads_again(device: Device, after: str) -> None:
    """Read once, which may fail, and then until the answers are certainly in step."""
    readable, channels = reader(device), names(device.channels)
    safely(f"reading with {after}", lambda: readable.read(channels))
    for _ in range(TRIES):
        try:
            readable.read(channels)
        except DeviceError as error:
            raise Nonconformity(f"after {after} it reads no more: {error}") from error


def _recovers_over_a_socket(subject: DeviceSubject, driver: LineDriver) -> None:
    """Talk to a peer that answers like the driver's simulator, but once late, or not at all."""
    with _serving(_Peer(driver)) as peer:
        for fault in ("late", "dropped"):
            timeout = f"{TIMEOUT_S} s"
            with subject.connected(
                address=peer.address, timeout=timeout, simulated=False
            ) as device:
                assert isinstance(device, LineDriver)  # noqa: S101  (as the driver)
                peer.fault = fault
                with _checking_answers(device, peer):
                    _reads_again(device, f"a {fault} answer over a socket")


@contextmanager
def _checking_answers(device: LineDriver, peer: _Peer) -> Iterator[None]:
    """Check that `ask` returns the answer to that very line."""
    ask = device.ask

    def checked_ask(request: str) -> str:
        answer = ask(request)
        demand(
            answer in peer.answers[request], f"it accepted '{answer}' as the answer to '{request}'"
        )
        return answer

    device.ask = checked_ask  # type: ignore[method-assign]  # for the check alone
    try:
        yield
    finally:
        del device.ask


class _Peer:
    """Answers lines like the simulator of a driver; the next answer may be late or missing."""

    def __init__(self, driver: LineDriver) -> None:
        self._instrument = driver.simulator()
        self._end = driver.terminator.encode("ascii")
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._lock = threading.Lock()
        self._over = threading.Event()
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"
        self.answers: dict[str, set[str]] = defaultdict(set)
        self.fault = ""

    def serve(self) -> None:
        """Accept connections, one after the other or several at once, until it is closed."""
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            threading.Thread(target=self._talk, args=(connection,), daemon=True).start()

    def close(self) -> None:
        """Accept no more connections."""
        self._over.set()
        with suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()

    def _talk(self, connection: socket.socket) -> None:
        received = b""
        with connection, suppress(OSError):
            while data := connection.recv(4096):
                received += data
                while self._end in received:
                    line, _, received = received.partition(self._end)
                    if not self._answer(connection, line.decode("ascii")):
                        return

    def _answer(self, connection: socket.socket, request: str) -> bool:
        """Answer a line; return False to drop the connection."""
        fault, self.fault = self.fault, ""
        if fault == "dropped":
            return False
        if fault == "late":
            self._over.wait(LATE_S)
        with self._lock:
            answer = self._instrument.answer(request)
        self.answers[request].add(answer)
        if answer:
            connection.sendall(answer.encode("ascii") + self._end)
        return True


@contextmanager
def _serving(peer: _Peer) -> Iterator[_Peer]:
    thread = threading.Thread(target=peer.serve, name="rigrunner check peer", daemon=True)
    thread.start()
    try:
        yield peer
    finally:
        peer.close()
        thread.join(1.0)


CHECKS = (recovers_after_a_failure,)
