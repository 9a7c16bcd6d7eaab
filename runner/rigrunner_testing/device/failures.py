"""Checks on a device whose exchanges with the instrument fail, one after the other.

Only if the record declares that every exchange goes over the wire: the kit is then the wire.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from rigrunner.api.devices import Readable, Streaming
from rigrunner.api.errors import (
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
)
from rigrunner.api.settings import MadeOfOthers
from rigrunner_testing.check import Nonconformity, applies, check, demand
from rigrunner_testing.device.doing import move, names, safely, streamed_names
from rigrunner_testing.device.subject import CONNECT_S, DeviceSubject

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.api.devices import Device
    from rigrunner.api.errors import DeviceError

_Answer = TypeVar("_Answer")
MOST_EXCHANGES = 25
"""The most exchanges of a session that are failed, one at a time."""
FAILURES: tuple[type[DeviceError], ...] = (DeviceTimeoutError, DeviceLostError, DeviceRejectedError)


@dataclass
class FaultyWire:
    """A Wire of which one exchange fails, or is answered with nonsense."""

    fails_at: int = -1
    failure: type[DeviceError] | None = None
    """The exception of that exchange; None: its answer is nonsense."""
    exchanges: int = 0
    failed: str = ""
    """The request that failed."""

    def exchange(self, request: str, perform: Callable[[], _Answer]) -> _Answer:
        """Exchange, unless it is the one that fails."""
        number, self.exchanges = self.exchanges, self.exchanges + 1
        if number != self.fails_at:
            return perform()
        self.failed = request
        if self.failure is not None:
            raise self.failure(f"{request}: made to fail by the check")
        answer: _Answer = nonsense(perform())
        return answer


def nonsense(answer: Any) -> Any:
    """Return a meaningless answer of the same type."""
    if isinstance(answer, bytes):
        return b"\xff\x00"
    if isinstance(answer, str):
        return "?!"
    if isinstance(answer, list):
        return []
    return answer


@check(
    moves=True,
    fix="do every exchange through `self.exchange(request, perform)`, or say `wired=False`",
    needs=("readings_are_true", "drives_go_where_they_are_set"),
)
def exchanges_go_over_the_wire(subject: DeviceSubject) -> None:
    """A wired device exchanges nothing past the wire."""
    applies(subject.record.wired, "its record does not say that it is wired")
    made_of_others = issubclass(subject.record.settings_model, MadeOfOthers)
    applies(not made_of_others, "the exchanges are those of the devices that it is made of")
    wire = FaultyWire()
    with subject.connected(wire=wire) as device:
        demand(wire.exchanges, "it connects without one exchange over the wire")
        before = wire.exchanges
        if isinstance(device, Readable):
            device.read(names(device.channels))
            demand(wire.exchanges > before, "it reads without one exchange over the wire")
        before = wire.exchanges
        if move(subject, device):
            demand(wire.exchanges > before, "it sets without one exchange over the wire")


@check(
    moves=True,
    fix="map the back end's exceptions in `errors` of Driver; check what you parse",
    needs=("exchanges_go_over_the_wire",),
)
def only_device_errors_leave_it(subject: DeviceSubject) -> None:
    """If an exchange fails, or is answered with nonsense, it raises a DeviceError and can close."""
    applies(subject.record.wired, "its record does not say that it is wired")
    intact = FaultyWire()
    _session(subject, intact)
    for number in range(min(intact.exchanges, MOST_EXCHANGES)):
        for failure in (FAILURES[number % len(FAILURES)], None):
            _session(subject, FaultyWire(number, failure))


def _session(subject: DeviceSubject, wire: FaultyWire) -> None:
    """Connect, read, set, stream, make safe and close: each succeeds or raises a DeviceError."""
    device = subject.make(wire=wire)
    try:
        for what, work in _calls(subject, device):
            if not _succeeds(what, work, wire):
                break
        safely(f"making safe after '{wire.failed}' failed", device.make_safe)
    finally:
        device.close()


def _succeeds(what: str, work: Callable[[], object], wire: FaultyWire) -> bool:
    fault = "answered with nonsense" if wire.failure is None else "made to fail"
    try:
        return safely(what, work)
    except Nonconformity as problem:
        raise Nonconformity(f"with '{wire.failed}' {fault}, {problem}") from problem


def _calls(subject: DeviceSubject, device: Device) -> Iterator[tuple[str, Callable[[], object]]]:
    yield "connecting", lambda: device.connect(CONNECT_S)
    if isinstance(device, Readable) and device.channels:
        reading: Readable = device
        yield "reading", lambda: reading.read(names(device.channels))
    if device.drives:
        yield "setting", lambda: move(subject, device)
    if isinstance(device, Streaming):
        streaming: Streaming = device
        token = threading.Event()
        yield "streaming", lambda: list(streaming.stream(streamed_names(device), 0.1, token))


CHECKS = (exchanges_go_over_the_wire, only_device_errors_leave_it)
