"""All devices of a station as one: connected together, made safe together, closed together."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Self, TypeVar

from rigrunner.api.calling import blocks_of
from rigrunner.api.devices import (
    CountsStreams,
    Identity,
    KnowsTruth,
    Patience,
    Pausable,
    Streaming,
)
from rigrunner.api.errors import DeviceRejectedError
from rigrunner.rig.drives import staying_away
from rigrunner.rig.held import HeldDrive, Shared
from rigrunner.rig.reading import (
    HeldChannels,
    found_of_stream,
    read_beside,
    refuse_unnamed,
    sample_rate_hz,
)
from rigrunner.rig.role import Role
from rigrunner.rig.safe_state import after_late_call, make_safe, note_unsafe, safe_places
from rigrunner.station.drive_rules import DriveRules
from rigrunner.yamlfile.names import split_member

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Mapping, Sequence
    from types import TracebackType

    from rigrunner.api.data import Block
    from rigrunner.api.devices import Clock, Device, DriveInfo, StopToken
    from rigrunner.rig.safe_state import SafetyReport

_T = TypeVar("_T")


def _nothing() -> None:
    pass


class Rig:
    """The devices by role. Every DeviceError that leaves it names the role.

    Devices that declare themselves non-blocking are called inline; each other one from a thread of
    its own, where a call that takes too long is abandoned and raises DeviceTimeoutError.
    """

    def __init__(
        self,
        devices: Mapping[str, Device],
        clock: Clock,
        patience: Patience | None = None,
        safe_order: Sequence[str] = (),
        rules: DriveRules | None = None,
    ) -> None:
        self.devices = dict(devices)
        self.clock = clock
        self._safe_order = tuple(safe_order)
        self._rules = rules or DriveRules()
        self._connected: set[str] = set()
        self._set_points: dict[str, float] = {}
        self._paused: list[str] = []
        self._patience = patience or Patience()
        self._roles = {name: Role(name, device) for name, device in self.devices.items()}
        self._shared = Shared(self._rules, self._patience, clock, self._set_points, self._standing)
        self._drives: dict[tuple[str, str], HeldDrive] = {}
        self._channels: dict[tuple[str, tuple[str, ...]], HeldChannels] = {}

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        reports = self.make_safe()
        if error is not None:
            note_unsafe(error, [each for each in reports if each.role in self._connected])
        try:
            self.close()
        except Exception as second:
            if error is None:
                raise
            error.add_note(f"closing the rig failed too: {second}")

    def connect(self) -> dict[str, Identity]:
        """Connect all and return who answered; if one fails, make safe and close all, and raise."""
        try:
            return {role: self._connect(role) for role in self.devices}
        except BaseException as error:
            self.__exit__(type(error), error, None)
            raise

    def set(
        self,
        role: str,
        drive: str,
        value: float,
        timeout_s: float | None = None,
        meanwhile: Callable[[], None] = _nothing,
    ) -> float:
        """Set a drive within its limits and return the read-back; raise a DeviceError.

        The read-back must agree within the drive's tolerance. It is waited for as long as the drive
        needs and `Patience` adds, or for `timeout_s`. `meanwhile` is called again and again while
        a drive that can be asked is on its way; what it raises ends the waiting.
        """
        return self._held(role, drive).move(timeout_s, meanwhile, value)

    def setter(
        self, role: str, drive: str, timeout_s: float | None, meanwhile: Callable[[], None]
    ) -> Callable[[float], float]:
        """Return what sets one drive as `set` does, again and again."""
        return partial(self._held(role, drive).move, timeout_s, meanwhile)

    def led_rate_per_s(self, role: str, drive: str) -> float | None:
        """Return how fast a drive is to be led, as the station says; None: it moves by itself."""
        return self._held(role, drive).led_rate_per_s

    def allowed(self, role: str, drive: str) -> DriveInfo:
        """Return a drive with the limits that the station sets it."""
        return self._rules.narrowed(f"{role}.{drive}", self._drive(role, drive))

    def standing(self, role: str, drive: str) -> float:
        """Return where a drive stands: its last set-point, or else what is read back."""
        return self._standing(f"{role}.{drive}")

    def read_back(self, role: str, drive: str) -> float:
        """Return where a drive is read back to stand."""
        return self._held(role, drive).read_back()

    def leads_away(self, role: str, drive: str, value: float) -> bool:
        """Say whether a set-point is farther from the safe value than where the drive stands."""
        safe = self._drive(role, drive).safe_value
        return abs(value - safe) > abs(self.standing(role, drive) - safe)

    def continue_after(self, streams: Mapping[str, Sequence[Mapping[str, float]]]) -> None:
        """Tell each device that asks for it which streams of its role the run has behind it."""
        for role, before in streams.items():
            device = self.devices[role]
            if isinstance(device, CountsStreams):
                self._call(role, "continue a run", partial(device.continue_after, before))

    def pause(self) -> list[str]:
        """Let every device stand still that can, in the order of making safe.

        Returns for each other one, in words, which of its drives stay away from their safe value.
        """
        staying = []
        for role, drive in safe_places(self._safe_order, self.devices):
            device = self.devices[role]
            if drive:
                continue
            if isinstance(device, Pausable):
                self._move(role, "pause", device.pause)
                self._paused.append(role)
            elif away := staying_away(role, device.drives, self._set_points):
                staying.append(f"{role} cannot pause: {', '.join(away)}")
        return staying

    def resume(self) -> None:
        """Bring back what was paused; the last one that was paused is the first."""
        while self._paused:
            role = self._paused[-1]
            device = self._roles[role].need(Pausable)  # type: ignore[type-abstract]  # a Protocol
            self._move(role, "resume", device.resume)
            self._paused.pop()

    def stream(
        self, role: str, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Generator[Block]:
        """Yield the blocks of one device until the duration has passed or the token is set."""
        device = self._roles[role].need(Streaming)  # type: ignore[type-abstract]  # a Protocol
        timeout_s = self._patience.answer_s + duration_s
        call = partial(self._call, role)
        yield from blocks_of(device, channels, duration_s, stop, call, timeout_s)

    def sample_rate_hz(self, role: str) -> float:
        """Return the sample rate of a device that streams."""
        return sample_rate_hz(self._roles[role])

    def truth(self, role: str) -> Mapping[str, float]:
        """Return what a simulator knows of its last stream; nothing of a real device."""
        device = self.devices[role]
        if not isinstance(device, KnowsTruth):
            return {}
        return self._call(role, "tell the truth", device.truth)

    def read(self, role: str, channels: Sequence[str]) -> dict[str, float]:
        """Return the present value of each channel by 'role.channel'; raise a DeviceError."""
        return self.reader(role, channels)()

    def reader(self, role: str, channels: Sequence[str]) -> Callable[[], dict[str, float]]:
        """Return what reads them as `read` does, again and again."""
        wanted = role, tuple(channels)
        held = self._channels.get(wanted)
        if held is None:
            held = HeldChannels(self._roles[role], wanted[1], self._patience.answer_s)
            self._channels[wanted] = held
        return held.read

    def conditions(
        self, role: str, streamed: Sequence[str]
    ) -> tuple[dict[str, float], dict[str, str]]:
        """Read once all that can be read beside the channels that the role streams.

        Returns values and units by 'role.channel'.
        """
        return read_beside(self._roles.values(), {role: streamed}, self._patience.answer_s)

    def stream_conditions(self, role: str) -> tuple[dict[str, float], dict[str, str]]:
        """Return what the role's device found of its last stream, as `conditions` does."""
        return found_of_stream(self._roles[role], self._patience.answer_s)

    def make_safe(self) -> tuple[SafetyReport, ...]:
        """Make every device safe, whatever happens to the others; never raises.

        Idempotent, and in the order that was given: first the drives and devices that it names,
        then the other devices, those that move in cycles before those that do not. A drive counts
        as safe once it is read back at its safe value. A call that was given up is waited for then:
        if it comes back, its device is made safe once more, and else it is not safe.
        """
        answer_s = self._patience.answer_s
        self._paused.clear()
        self._set_points.clear()
        given_up = {role.name: late for role in self._roles.values() if (late := role.late)}

        def made_safe(role: str, drive: str) -> SafetyReport:
            return make_safe(role, drive, self.devices[role], self._roles[role].caller, answer_s)

        reports = [
            made_safe(role, drive)
            for role, drive in safe_places(self._safe_order, self.devices)
            if not drive or role in self._connected
        ]
        return tuple(
            after_late_call(each, late, partial(made_safe, each.role, ""))
            if not each.drive and (late := given_up.get(each.role))
            else each
            for each in reports
        )

    def close(self) -> None:
        """Close every device; the first error is raised after all were tried."""
        errors: list[Exception] = []
        for role in self._roles.values():
            try:
                with role.named():
                    role.caller.call_urgently("close", role.device.close, self._patience.answer_s)
            except Exception as error:  # noqa: BLE001  (raised below, after the others)
                errors.append(error)
            role.caller.stop()
        if errors:
            raise errors[0]

    def _connect(self, role: str) -> Identity:
        limit_s, connect = self._patience.connect_s, self.devices[role].connect
        identity = self._call(role, "connect", lambda: connect(limit_s), 2 * limit_s)
        self._connected.add(role)
        refuse_unnamed(role, identity)
        self._roles[role].look_anew()
        self._drives.clear()
        self._channels.clear()
        return identity

    def _standing(self, member: str) -> float:
        if member in self._set_points:
            return self._set_points[member]
        role, drive = split_member(member)
        found = self.read_back(role, drive)
        if not math.isfinite(found):  # compared with any limit it would seem to be within
            raise DeviceRejectedError(
                f"{role}: {drive} reads back {found:g}: it may stand anywhere"
            )
        return found

    def _longest_s(self, role: str) -> float:
        return self._patience.answer_s + sum(info.longest_s for info in self.devices[role].drives)

    def _drive(self, role: str, drive: str) -> DriveInfo:
        return self._roles[role].drive(drive)

    def _held(self, role: str, drive: str) -> HeldDrive:
        held = self._drives.get((role, drive))
        if held is None:
            held = HeldDrive(self._roles[role], drive, self._shared)
            self._drives[role, drive] = held
        return held

    def _move(self, role: str, what: str, function: Callable[[], _T]) -> _T:
        """Call what moves all drives of a device."""
        limit_s = self._longest_s(role)
        return self._call(role, what, self._roles[role].moving(what, function, limit_s), limit_s)

    def _call(
        self, role: str, what: str, function: Callable[[], _T], timeout_s: float | None = None
    ) -> _T:
        limit_s = self._patience.answer_s if timeout_s is None else timeout_s
        return self._roles[role].call(what, function, limit_s)
