"""Checks on making safe: in every state, repeatedly, confirmed by read-back."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from rigrunner.api.calling import InlineCaller
from rigrunner.api.devices import Pausable, Settable
from rigrunner.api.driver import Driver
from rigrunner.api.errors import DeviceError
from rigrunner.rig.safe_state import make_safe
from rigrunner_testing.check import Nonconformity, NotApplicable, check, demand
from rigrunner_testing.device.doing import (
    actual_if_off,
    close_stream,
    defined_at,
    move,
    safely,
    setter,
    streamed_names,
    streamer,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.api.devices import Device
    from rigrunner_testing.device.subject import DeviceSubject

NO_SUCH = "no_such_name"


@check(
    moves=True,
    fix="return every drive's read-back; where nothing is known raise DeviceLostError",
)
def safe_before_connecting(subject: DeviceSubject) -> None:
    """Before connecting, making safe does no harm: it reports the drives, or that it cannot."""
    device = subject.make()
    read_back: list[Mapping[str, float]] = []
    if safely("making safe before connecting", lambda: read_back.append(device.make_safe())):
        _check_safe_values(device, read_back[0])
    device.close()


@check(
    moves=True,
    fix="set every drive to its safe value, read each back, and return these",
    needs=("drives_go_where_they_are_set",),
)
def safe_is_confirmed(subject: DeviceSubject) -> None:
    """Making safe, also repeated, sets every drive to its safe value and reports read-backs."""
    with subject.connected() as device:
        drives = setter(device)
        move(subject, device)
        for _ in range(2):
            _check_safe_values(device, device.make_safe())
            _check_drives_safe(device, drives)


@check(
    moves=True,
    fix="let `make_safe` need nothing of a stream, and a stream end when left",
    needs=("safe_is_confirmed", "blocks_are_whole"),
)
def safe_while_streaming(subject: DeviceSubject) -> None:
    """Making safe works during a stream, and the next stream starts from the beginning."""
    with subject.connected() as device:
        streaming, drives = streamer(device), setter(device)
        move(subject, device)
        stream = iter(streaming.stream(streamed_names(device), 2.0, threading.Event()))
        next(stream, None)
        _check_safe_values(device, device.make_safe())
        _check_drives_safe(device, drives)
        close_stream(stream)
        block = next(iter(streaming.stream(streamed_names(device), 0.1, threading.Event())), None)
        if block is None:
            raise Nonconformity("after a stream that was left it streams no more")
        demand(block.first_sample == 0, f"the next stream begins with sample {block.first_sample}")


@check(
    moves=True,
    fix="keep no state of a call that failed; see `Driver`",
    needs=("safe_is_confirmed",),
)
def safe_after_a_failed_call(subject: DeviceSubject) -> None:
    """Making safe works after a refused call."""
    with subject.connected() as device:
        drives = setter(device)
        move(subject, device)
        for info in device.drives:
            beyond = info.maximum + (info.maximum - info.minimum)
            with suppress(Exception):  # checks of their own look at how it refuses
                drives.set(info.name, beyond)
        with suppress(Exception):
            drives.set(NO_SUCH, 0.0)
        _check_safe_values(device, device.make_safe())
        _check_drives_safe(device, drives)


@check(
    moves=True,
    fix="try every drive even if one of them raises, as `rigrunner.api.cleanup.do_all` does",
    needs=("safe_is_confirmed",),
)
def safe_though_one_drive_fails(subject: DeviceSubject) -> None:
    """If a call of one drive, or all of `make_safe`, raises, the other drives are made safe."""
    with subject.connected() as device:
        setter(device)
        # Of a Driver it is known which calls its own `make_safe` makes.
        broken_calls: tuple[tuple[str, BaseException], ...] = (
            (("actual", IndexError("made by the check")), ("put", SystemExit(1)))
            if isinstance(device, Driver)
            else ()
        )
        for method, error in broken_calls:
            for broken in device.drives:
                move(subject, device)
                with _raising(device, method, broken.name, error), suppress(Exception, SystemExit):
                    device.make_safe()
                _check_others_safe(device, broken.name, f"`{method}` of {broken.name} raised")
        move(subject, device)
        with _raising(device, "make_safe", "", IndexError("made by the check")):
            make_safe(subject.role, "", device, InlineCaller(), 0.0, connected=True)
        _check_others_safe(device, "", "`make_safe` raised, each drive was set by itself")


def _check_others_safe(device: Device, broken: str, why: str) -> None:
    drives = setter(device)
    for info in device.drives:
        actual = None if info.name == broken else actual_if_off(drives, info, info.safe_value)
        demand(actual is None, f"{why}, and {info.name} was left at {actual} {info.unit}")


@contextmanager
def _raising(device: Device, method: str, broken: str, error: BaseException) -> Iterator[None]:
    """Let a method of a device raise, for one of its drives or for a device without drives."""
    original: Callable[..., object] = getattr(device, method)

    def broken_method(*arguments: object) -> object:
        if not broken or broken in arguments:
            raise error
        return original(*arguments)

    setattr(device, method, broken_method)
    try:
        yield
    finally:
        delattr(device, method)


@check(
    moves=True,
    fix="raise DeviceLostError where `make_safe` cannot reach the instrument any more",
    needs=("safe_is_confirmed",),
)
def safe_after_closing(subject: DeviceSubject) -> None:
    """After closing, making safe reports the truth: safe values that hold, or that it cannot."""
    with subject.connected() as device:
        setter(device)
        move(subject, device)
        device.make_safe()
        device.close()
        read_back: list[Mapping[str, float]] = []
        if safely("making safe after closing", lambda: read_back.append(device.make_safe())):
            _check_safe_values(device, read_back[0])
        device.close()


@check(
    moves=True,
    fix="`resume` goes back to what `pause` has kept, and `make_safe` forgets that",
    needs=("safe_is_confirmed",),
)
def pauses_and_resumes(subject: DeviceSubject) -> None:
    """A paused device stands still and then resumes; after it is made safe, it does not resume."""
    with subject.connected() as device:
        drives = setter(device)
        if not isinstance(device, Pausable):
            raise NotApplicable("it does not pause")
        set_points = move(subject, device)
        cyclic = [info for info in device.drives if info.sets_cycle_frequency]
        device.pause()
        for info in cyclic:
            actual = actual_if_off(drives, info, info.safe_value)
            demand(actual is None, f"paused, {info.name} is at {actual}")
        device.resume()
        for info in device.drives:
            actual = actual_if_off(drives, info, set_points[info.name])
            demand(actual is None, f"resumed, {info.name} is at {actual}, not as before")
        device.pause()
        device.make_safe()
        with suppress(DeviceError):
            device.resume()
        _check_drives_safe(device, drives)


@check(
    moves=True,
    fix="make sure that `make_safe` works after every other call",
    needs=("safe_is_confirmed",),
    always=True,
)
def left_safe(subject: DeviceSubject) -> None:
    """After all checks its drives are at their safe values."""
    with subject.connected() as device:
        setter(device)
        try:
            read_back = device.make_safe()
        except DeviceError as error:
            raise Nonconformity(f"NOT SAFE: {error}; make the rig safe by hand") from error
        _check_safe_values(device, read_back)


def _check_safe_values(device: Device, read_back: Mapping[str, float]) -> None:
    answer = f"{read_back!r}{defined_at(device, 'make_safe')}"
    is_mapping = isinstance(read_back, Mapping)
    demand(is_mapping, f"`make_safe` gave {answer}, expected what each drive reads")
    missing = [info.name for info in device.drives if info.name not in read_back]
    demand(not missing, f"making safe returns nothing for {', '.join(missing)}")
    for info in device.drives:
        actual = read_back[info.name]
        demand(
            abs(actual - info.safe_value) <= info.allowed_deviation,
            f"made safe, {info.name} reads back {actual:g} {info.unit}, safe is"
            f" {info.safe_value:g} {info.unit}",
        )


def _check_drives_safe(device: Device, drives: Settable) -> None:
    for info in device.drives:
        actual = actual_if_off(drives, info, info.safe_value)
        demand(actual is None, f"made safe, {info.name} is at {actual} {info.unit}")


CHECKS = (
    safe_before_connecting,
    safe_is_confirmed,
    safe_while_streaming,
    safe_after_a_failed_call,
    safe_though_one_drive_fails,
    safe_after_closing,
    pauses_and_resumes,
)
