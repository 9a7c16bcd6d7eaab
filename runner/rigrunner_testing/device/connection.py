"""Checks on connecting, identifying and closing."""

from __future__ import annotations

import threading
from functools import partial
from typing import TYPE_CHECKING

from rigrunner.api.devices import Identity, KnowsTruth, Readable, Settable, Streaming
from rigrunner.api.errors import DeviceError
from rigrunner_testing.check import Nonconformity, applies, check, demand
from rigrunner_testing.device.doing import defined_at, names, refusal, safely, streamed_names
from rigrunner_testing.device.watching import census, leaks_since, watch_accesses
from rigrunner_testing.own_time import measured

if TYPE_CHECKING:
    from rigrunner_testing.device.subject import DeviceSubject

GIVEN_S = 1.0
"""The time-out within which a device without its instrument gives up."""
GRACE_S = 1.0
"""Time allowed beyond the time-out of connecting: a process that starts, a delayed packet."""
ROUNDS = 3


@check(fix="open sockets, ports and threads in `connect`; the constructor keeps what it is given")
def construction_touches_nothing(subject: DeviceSubject) -> None:
    """Creating the device opens no connection, so that a plan can be made without the rig."""
    subject.make()  # so that imports of the factory do not count
    before = census()
    with watch_accesses() as accesses:
        subject.make()
    demand(not accesses, f"making it did: {', '.join(accesses)}")
    leaks = leaks_since(before)
    demand(not leaks, f"making it left behind: {leaks}")


@check(fix="fill in `maker`, `model` and `serial` of the Identity; `simulated=True` of a simulator")
def connects_and_says_who_it_is(subject: DeviceSubject) -> None:
    """It connects, and gives maker, model and serial number, and whether it is simulated."""
    device = subject.make()
    try:
        identity = device.connect(5.0)
    except DeviceError as error:
        raise Nonconformity(f"it does not connect: {error.message}", fix=error.hint) from error
    place = defined_at(device, "open") or defined_at(device, "connect")
    is_identity = isinstance(identity, Identity)
    demand(is_identity, f"connecting gave {identity!r}{place}, expected an Identity")
    missing = [field for field in ("maker", "model") if not getattr(identity, field).strip()]
    if not identity.simulated and not identity.serial.strip():
        missing.append("serial")
    demand(not missing, f"the identity has no {', '.join(missing)}")
    demand(
        subject.simulated or not identity.simulated,
        "its identity says that it is simulated, but its record does not",
    )
    invents = isinstance(device, KnowsTruth) or "seed" in subject.record.settings_model.model_fields
    demand(
        identity.simulated or not (subject.simulated and invents),
        "it generates its samples, but its identity does not say that it is simulated",
    )


@check(
    fix="pass the time-out to the back end; state in `absent` the settings for which no"
    " instrument answers",
    needs=("connects_and_says_who_it_is",),
)
def gives_up_in_time(subject: DeviceSubject) -> None:
    """Without an answer, connecting ends within its time-out with a DeviceError."""
    applies(
        subject.record.absent, "its record does not state settings for which no instrument answers"
    )
    device = subject.make(**subject.record.absent)
    what = "connecting without an instrument"
    took_s = measured(lambda: refusal(what, lambda: device.connect(GIVEN_S))).took_s
    demand(
        took_s <= GIVEN_S + GRACE_S,
        f"it took {took_s:.1f} s to give up; the time-out was {GIVEN_S:g} s",
    )
    if not subject.read_only:
        safely("making safe after that", device.make_safe)
    device.close()
    device.close()


@check(fix="raise DeviceLostError where it is not connected; `Driver` does that by itself")
def needs_a_connection(subject: DeviceSubject) -> None:
    """Without a connection every call except making safe and closing is refused."""
    device = subject.make()
    channels = names(device.channels)
    if isinstance(device, Readable) and channels:
        refusal("reading", lambda: device.read(channels))
    if isinstance(device, Settable):
        for info in device.drives:
            refusal(f"setting {info.name}", partial(device.set, info.name, info.safe_value))
            refusal(f"reading back {info.name}", partial(device.read_back, info.name))
    if isinstance(device, Streaming):
        token = threading.Event()
        streamed = [info.name for info in device.channels if info.streams]
        refusal("streaming", lambda: list(device.stream(streamed, 0.1, token)))
    applies(channels or device.drives, "it has neither channels nor drives")


@check(
    fix="let `close` do nothing where nothing is open, and forget the connection",
    needs=("connects_and_says_who_it_is",),
)
def closes_in_every_state(subject: DeviceSubject) -> None:
    """Closing works before connecting and twice, and connecting works after it."""
    device = subject.make()
    device.close()
    for _ in range(2):
        device.connect(5.0)
        device.close()
        device.close()


@check(
    fix="end threads and close files and sockets in `close`, also after a failed `connect`",
    needs=(
        "connects_and_says_who_it_is",
        "construction_touches_nothing",
        "readings_are_true",
        "blocks_are_whole",
    ),
)
def gives_back_what_it_took(subject: DeviceSubject) -> None:
    """After closing it leaves no thread, no open file and no socket."""
    _use(subject)  # so that lazy imports do not count
    before = census()
    for _ in range(ROUNDS):
        _use(subject)
    leaks = leaks_since(before)
    demand(not leaks, f"{ROUNDS} rounds of connecting, reading and closing left behind: {leaks}")
    if subject.record.absent:
        _fail(subject)
        before = census()
        _fail(subject)
        leaks = leaks_since(before)
        demand(not leaks, f"a connection that failed left behind: {leaks}")


def _use(subject: DeviceSubject) -> None:
    with subject.connected() as device:
        if isinstance(device, Readable):
            device.read(names(device.channels))
        if isinstance(device, Streaming):
            for _ in device.stream(streamed_names(device)[:1], 1.0, threading.Event()):
                break


def _fail(subject: DeviceSubject) -> None:
    device = subject.make(**subject.record.absent)
    refusal("connecting without an instrument", lambda: device.connect(GIVEN_S))
    device.close()


CHECKS = (
    construction_touches_nothing,
    connects_and_says_who_it_is,
    gives_up_in_time,
    needs_a_connection,
    closes_in_every_state,
)
