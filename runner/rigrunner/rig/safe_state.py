"""How a drive or device is made safe, and the order of all."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from threading import Thread
from typing import TYPE_CHECKING, TypeVar

from rigrunner.api.calling import ThreadCaller
from rigrunner.api.cleanup import error_text
from rigrunner.api.devices import Settable
from rigrunner.api.errors import DeviceRejectedError
from rigrunner.api.member import Member
from rigrunner.api.quantity import legible
from rigrunner.rig.drives import agrees, as_number

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from rigrunner.api.calling import Caller, MovingCall
    from rigrunner.api.devices import Device, DriveInfo

_Value = TypeVar("_Value")
_ATTEMPTS = 3
"""Number of attempts to make one device safe after interrupts."""
_SLICE_S = 0.1
"""Waiting is sliced, since on Windows no signal interrupts it."""


class NoRigError(DeviceRejectedError):
    """A replay that differs from its tape has no answer: there is no rig."""


@dataclass(frozen=True)
class SafetyReport:
    """Whether a device, or one of its drives, is safe: the read-backs and the problems.

    After an unsafe drive the whole device is made safe: only the report of the device states how it
    was left.
    """

    role: str
    read_back: Mapping[str, float] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
    drive: str = ""
    """The drive that was made safe; empty for the whole device."""
    there: bool = True
    """False in a replay that differs from its tape: there is nothing to be left unsafe."""
    units: Mapping[str, str] = field(default_factory=dict)
    """The unit of each drive."""

    @property
    def safe(self) -> bool:
        """True if every drive was read back at its safe value."""
        return not self.problems

    @property
    def what(self) -> str:
        """The role of the device, or 'role.drive'."""
        return Member(self.role, self.drive) if self.drive else self.role

    def by_member(self, values: Mapping[str, _Value]) -> dict[str, _Value]:
        """Return values of drives by 'role.drive'."""
        return {Member(self.role, drive): value for drive, value in values.items()}


def unsafe_text(reports: Iterable[SafetyReport]) -> str:
    """Return the problems of each unsafe device; '' for a rig that was left safe."""
    return problems_text(report for report in reports if report.there)


def problems_text(reports: Iterable[SafetyReport]) -> str:
    """Return the problems of each device, also of replays; '' for none."""
    devices = [report for report in reports if not report.drive]
    return "; ".join(f"{report.role}: {text}" for report in devices for text in report.problems)


def note_unsafe(error: BaseException, reports: Iterable[SafetyReport]) -> None:
    """Add unsafe devices to an error as a note, once."""
    unsafe = unsafe_text(reports)
    text = f"the rig is not safe: {unsafe}"
    if unsafe and text not in getattr(error, "__notes__", ()):
        error.add_note(text)


def safe_places(
    order: Sequence[Member | str], devices: Mapping[str, Device]
) -> list[tuple[str, str]]:
    """Return each drive (role, drive) and device (role, '') in the order of making safe.

    First those in the given order, then the remaining devices, cyclically moving ones first.
    """
    named = [(m.role, m.name) if isinstance(m, Member) else (m, "") for m in order]
    last = sorted(devices, key=lambda role: not _moves_in_cycles(devices[role]))
    return list(dict.fromkeys([*named, *((role, "") for role in last)]))


def make_safe(
    role: str, drive: str, device: Device, caller: Caller, answer_s: float, *, connected: bool
) -> SafetyReport:
    """Make a device or one of its drives safe, and read back; never raises.

    `answer_s` is the time limit beyond the time that the drives need. If the `make_safe` of a
    connected device fails, each of its drives is set by itself, since the failure may have come
    before some of them.
    """
    for _ in range(_ATTEMPTS):
        try:
            return _made_safe(role, drive, device, caller, answer_s, connected=connected)
        except KeyboardInterrupt:
            continue  # impatience must not leave a rig half safe
    return interrupted(role, drive)


def interrupted(role: str, drive: str) -> SafetyReport:
    """Return the report of a device or drive that a person did not wait for."""
    return SafetyReport(role, {}, ("make safe was interrupted from the keyboard",), drive)


def settle_all(roles: Iterable[str], inline: Iterable[str], settle: Callable[[str], None]) -> None:
    """Call `settle` for each of the roles at the same time, and for `inline` one after another.

    Returns once all have returned, which have time limits of their own; or, without a time limit,
    at the third interrupt from the keyboard.
    """
    threads = []
    for role in roles:
        thread = Thread(target=settle, args=(role,), name=f"make safe {role}", daemon=True)
        try:
            thread.start()
        except RuntimeError:  # the system has no thread left
            settle(role)
        else:
            threads.append(thread)
    for role in inline:
        settle(role)
    interrupts = 0
    while interrupts < _ATTEMPTS and (running := [t for t in threads if t.is_alive()]):
        try:
            running[0].join(_SLICE_S)
        except KeyboardInterrupt:
            interrupts += 1


def _made_safe(
    role: str, drive: str, device: Device, caller: Caller, answer_s: float, *, connected: bool
) -> SafetyReport:
    infos, problems = _drives_of(device, drive)
    units = {info.name: info.unit for info in infos}
    work = partial(_set_safe, device, drive) if drive else device.make_safe
    try:
        timeout_s = answer_s + sum(info.longest_s for info in infos)
        returned = caller.call_urgently("make safe", work, timeout_s)
        read_back = {name: as_number(value) for name, value in returned.items()}
        problems += _unsafe(infos, read_back)
        return SafetyReport(role, read_back, tuple(problems), drive, units=units)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001  (reported; the next device follows)
        there = not isinstance(error, NoRigError)
        problems.append(f"make safe failed: {error_text(error)}")
        read_back = {}
        if there and connected and not drive and isinstance(device, Settable):
            read_back, drive_problems = _drive_by_drive(infos, device, caller, answer_s)
            problems += drive_problems
        return SafetyReport(role, read_back, tuple(problems), drive, there, units)


def _drives_of(device: Device, drive: str) -> tuple[list[DriveInfo], list[str]]:
    """Return the drives to make safe, or the problem: a device is made safe without its list."""
    try:
        return [info for info in device.drives if drive in ("", info.name)], []
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001  (reported; the device must be made safe)
        return [], [f"its drives cannot be listed: {error_text(error)}"]


def _drive_by_drive(
    infos: Iterable[DriveInfo], device: Device, caller: Caller, answer_s: float
) -> tuple[dict[str, float], list[str]]:
    """Set each drive to its safe value; return the read-backs and the problems."""
    read_back: dict[str, float] = {}
    problems: list[str] = []
    for info in infos:
        work, timeout_s = partial(_set_safe, device, info.name), answer_s + info.longest_s
        try:
            returned = caller.call_urgently("make safe", work, timeout_s)
            read_back[info.name] = as_number(returned[info.name])
            problems += _unsafe([info], read_back)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # noqa: BLE001  (reported; the next drive follows)
            problems.append(f"{info.name} cannot be made safe: {error_text(error)}")
    return read_back, problems


def after_late_call(
    report: SafetyReport, late: MovingCall, make_safe_again: Callable[[], SafetyReport]
) -> SafetyReport:
    """Return the state of a device with a moving call that exceeded its time limit; never raises.

    A late call can undo making safe: after it the device is made safe again. Until it returns,
    the read-back may change.
    """
    # A Ctrl-C ends the wait, not the report.
    with suppress(KeyboardInterrupt):
        late.wait(ThreadCaller.grace_s)
    if late.has_returned:
        return make_safe_again()
    text = f"'{late.what}' was given up and has not come back: it may still move the drive"
    return replace(report, problems=(*report.problems, text))


def _set_safe(device: Device, drive: str) -> Mapping[str, float]:
    info = next((info for info in device.drives if info.name == drive), None)
    if info is None or not isinstance(device, Settable):
        raise DeviceRejectedError(f"there is no drive '{drive}' that can be set")
    device.set(drive, info.safe_value)
    return {drive: device.read_back(drive)}


def _moves_in_cycles(device: Device) -> bool:
    try:
        return any(info.sets_cycle_frequency for info in device.drives)
    except BaseException:  # noqa: BLE001  (a driver may raise anything; each device must be made safe)
        return False


def _unsafe(infos: Sequence[DriveInfo], read_back: Mapping[str, float]) -> Iterator[str]:
    for info in infos:
        if not agrees(info, read_back.get(info.name, math.nan), info.safe_value):
            actual = read_back.get(info.name)
            text = "nothing" if actual is None else legible(actual, info.unit)
            yield f"{info.name} reads back {text}, safe is {legible(info.safe_value, info.unit)}"
