"""All devices of a station: connected, made safe and closed together."""

from __future__ import annotations

import math
from contextlib import nullcontext
from functools import partial
from threading import Thread
from typing import TYPE_CHECKING, Self, TypeVar

from rigrunner.api.calling import blocks_of
from rigrunner.api.cleanup import add_beside, do_all, error_text
from rigrunner.api.devices import (
    CountsStreams,
    Identity,
    KnowsTruth,
    Patience,
    Pausable,
    Streaming,
)
from rigrunner.api.errors import DeviceError, DeviceRejectedError
from rigrunner.api.member import Member
from rigrunner.rig.connected_drive import ConnectedDrive, Shared
from rigrunner.rig.cycles import CycleCount
from rigrunner.rig.drives import away_from_safe
from rigrunner.rig.messages import DeviceMessages
from rigrunner.rig.pulse import PulseClock
from rigrunner.rig.reading import (
    ChannelReader,
    check_identity,
    observe,
    plain_identity,
    read_conditions,
    sample_rate_hz,
    stream_conditions,
)
from rigrunner.rig.role import Role
from rigrunner.rig.safe_state import (
    after_late_call,
    interrupted,
    make_safe,
    note_unsafe,
    safe_places,
    settle_all,
)
from rigrunner.station.drive_rules import DriveRules

if TYPE_CHECKING:
    from collections.abc import Callable, Container, Generator, Iterator, Mapping, Sequence
    from contextlib import AbstractContextManager
    from types import TracebackType

    from rigrunner.api.data import Block
    from rigrunner.api.devices import Clock, Device, DriveInfo, StopToken
    from rigrunner.api.readings import Reading
    from rigrunner.rig.pulse import Pulse
    from rigrunner.rig.safe_state import SafetyReport
    from rigrunner.rig_state import RigMarks

_T = TypeVar("_T")


class Rig:
    """The devices by role. Every DeviceError names the role.

    Non-blocking devices are called inline; each other one in its own thread, where a call that
    takes too long is abandoned and raises DeviceTimeoutError.
    """

    def __init__(
        self,
        devices: Mapping[str, Device],
        clock: Clock,
        patience: Patience | None = None,
        safe_order: Sequence[Member | str] = (),
        rules: DriveRules | None = None,
        *,
        marks: RigMarks | None = None,
        pulse: Pulse | None = None,
    ) -> None:
        self.devices = dict(devices)
        self.clock: Clock = clock if pulse is None else PulseClock(clock, pulse)
        self._pulse = pulse
        self.messages = DeviceMessages()
        """Log messages of the drivers."""
        self._safe_order = tuple(safe_order)
        self._rules = rules or DriveRules()
        self._connected: set[str] = set()
        self._set_points: dict[Member, float] = {}
        self._paused: list[str] = []
        self._patience = patience or Patience()
        self._roles = {name: Role(name, device, pulse) for name, device in self.devices.items()}
        self._marks = marks
        self.cycles = CycleCount(clock)
        """Cycles of each role, from the frequencies that were set."""
        self._shared = Shared(
            self._rules, self._patience, clock, self._set_points, self._standing, self.cycles, marks
        )
        self._drives: dict[tuple[str, str], ConnectedDrive] = {}
        self._channels: dict[tuple[str, tuple[str, ...]], ChannelReader] = {}

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
            note_unsafe(error, [report for report in reports if report.role in self._connected])
        try:
            self.close()
        except Exception as second:
            if error is None:
                raise
            add_beside(error, f"closing the rig failed too: {error_text(second)}")

    def connect(self) -> dict[str, Identity]:
        """Connect all and return their identities; if one fails, make safe, close all and raise."""
        try:
            return {role: self._connect(role) for role in self.devices}
        except BaseException as error:
            self.__exit__(type(error), error, None)
            raise

    def connect_each(self) -> dict[str, str]:
        """Connect all at the same time; return why each failed device did not connect."""
        failed: dict[str, str] = {}

        def connect(role: str) -> None:
            try:
                self._connect(role)
            except BaseException as error:  # noqa: BLE001  (reported; the others still connect)
                failed[role] = error_text(error)

        # Longer than `_connect` takes at most: only a device that is called inline needs it.
        limit_s = 3 * self._patience.connect_s
        connecting = {
            role: Thread(target=connect, args=(role,), daemon=True) for role in self.devices
        }
        for thread in connecting.values():
            thread.start()
        for role, thread in connecting.items():
            thread.join(limit_s)
            if thread.is_alive():  # a device that is called inline has no time limit
                failed[role] = f"'connect' did not return within {limit_s:.3g} s"
        # A copy: a thread that was given up may still add its error.
        return dict(failed)

    def person(self) -> AbstractContextManager[None]:
        """Note that a person is asked and may take any time."""
        return nullcontext() if self._pulse is None else self._pulse.person()

    def set(
        self,
        role: str,
        drive: str,
        value: float,
        timeout_s: float | None = None,
        meanwhile: Callable[[], None] = lambda: None,
    ) -> float:
        """Set a drive within its limits and return the read-back; raise a DeviceError.

        The read-back must agree within the tolerance of the drive. The time limit is what the drive
        needs plus `Patience`, or `timeout_s`. `meanwhile` is called repeatedly while a drive that
        can be polled moves; its exceptions end the wait.
        """
        return self._connected_drive(role, drive).move(timeout_s, meanwhile, value)

    def setter(
        self, role: str, drive: str, timeout_s: float | None, meanwhile: Callable[[], None]
    ) -> Callable[[float], float]:
        """Return a function that sets one drive repeatedly, as `set` does."""
        return partial(self._connected_drive(role, drive).move, timeout_s, meanwhile)

    def led_rate_per_s(self, role: str, drive: str) -> float | None:
        """Return the rate at which to move a drive, from the station; None: it moves by itself."""
        return self._connected_drive(role, drive).led_rate_per_s

    def allowed(self, role: str, drive: str) -> DriveInfo:
        """Return a drive with the limits of the station."""
        return self._rules.narrowed(Member(role, drive), self._roles[role].drive(drive))

    def standing(self, role: str, drive: str) -> float:
        """Return the position of a drive: its last set-point, or else the read-back."""
        return self._standing(Member(role, drive))

    def read_back(self, role: str, drive: str) -> float:
        """Return the read-back of a drive."""
        return self._connected_drive(role, drive).read_back()

    def deviating_drives(self, excluded: Container[str] = ()) -> Iterator[tuple[Member, str]]:
        """Read back each drive that was set; yield each that left its set-point, with a text.

        A deviation is confirmed by a second read-back. Skips devices in `excluded`, and all while
        the rig is paused. Raises a DeviceError.
        """
        if self._paused:
            return
        for member, value in tuple(self._set_points.items()):
            if member.role in excluded:
                continue
            drive = self._connected_drive(member.role, member.name)
            if drive.stands_at(drive.read_back(), value):
                continue
            actual = drive.read_back()
            if not drive.stands_at(actual, value):
                unit, deviation = drive.info.unit, drive.info.allowed_deviation
                text = f"{member} was set to {value:g} {unit} and reads back {actual:g} {unit}"
                yield member, f"{text} (tolerance ±{deviation:g} {unit})"

    def leads_away(self, role: str, drive: str, value: float) -> bool:
        """Return whether a set-point is farther from the safe value than the present position.

        The safe value itself never is, also where the present position cannot be read.
        """
        safe = self._roles[role].drive(drive).safe_value
        return value != safe and abs(value - safe) > abs(self.standing(role, drive) - safe)

    def resume_leads_away(self, role: str, drive: str) -> bool:
        """Return whether `resume` would move a drive of a paused device away from its safe value.

        True also if its position is not known.
        """
        value = self._set_points.get(Member(role, drive))
        if role not in self._paused or value is None:
            return False
        connected = self._connected_drive(role, drive)
        safe = connected.info.safe_value
        try:
            actual = connected.read_back()
        except DeviceError:
            actual = math.nan
        stands = connected.stands_at(actual, value)
        return not stands and not abs(value - safe) <= abs(actual - safe)

    def continue_after(self, streams: Mapping[str, Sequence[Mapping[str, float]]]) -> None:
        """Inform each device that needs it which earlier streams of its role the run has."""
        for role, before in streams.items():
            device = self.devices[role]
            if isinstance(device, CountsStreams):
                self._call(role, "continue a run", partial(device.continue_after, before))

    def pause(self) -> list[str]:
        """Pause every device that can, in the order of making safe.

        Returns for each other device, as text, which of its drives are not at their safe value.
        """
        unpausable = []
        for role, drive in safe_places(self._safe_order, self.devices):
            device = self.devices[role]
            # A device pauses as a whole.
            if drive:
                continue
            if isinstance(device, Pausable):
                self._move(role, "pause", device.pause)
                self.cycles.pause(role)
                self._paused.append(role)
            elif away := away_from_safe(role, device.drives, self._set_points):
                unpausable.append(f"{role} cannot pause: {', '.join(away)}")
        return unpausable

    def resume(self) -> None:
        """Resume what was paused, in reverse order."""
        while self._paused:
            role = self._paused[-1]
            device = self._roles[role].need(Pausable)  # type: ignore[type-abstract]  # a Protocol
            self._move(role, "resume", device.resume)
            self.cycles.resume(role)
            # Last: a device that did not resume is still paused.
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
        """Return the sample rate of a streaming device."""
        return sample_rate_hz(self._roles[role])

    def truth(self, role: str) -> Mapping[str, float]:
        """Return the truth of a simulator on its last stream; empty for a real device."""
        device = self.devices[role]
        if not isinstance(device, KnowsTruth):
            return {}
        return self._call(role, "tell the truth", device.truth)

    def read(self, role: str, channels: Sequence[str]) -> dict[str, float]:
        """Return the present value of each channel by 'role.channel'; raise a DeviceError."""
        return self.reader(role, channels)()

    def observe(self, role: str, readings: Sequence[str]) -> dict[str, Reading]:
        """Return readings of a device that are not numbers, by 'role.name'; raise a DeviceError."""
        return observe(self._roles[role], readings, self._patience.answer_s)

    def reader(self, role: str, channels: Sequence[str]) -> Callable[[], dict[str, float]]:
        """Return a function that reads channels repeatedly, as `read` does."""
        key = role, tuple(channels)
        reader = self._channels.get(key)
        if reader is None:
            reader = ChannelReader(self._roles[role], key[1], self._patience.answer_s)
            self._channels[key] = reader
        return reader.read

    def conditions(
        self, role: str, streamed: Sequence[str]
    ) -> tuple[dict[str, float], dict[str, str]]:
        """Read once everything that can be read while the role streams.

        Returns values and units by 'role.channel'.
        """
        return read_conditions(self._roles.values(), {role: streamed}, self._patience.answer_s)

    def stream_conditions(self, role: str) -> tuple[dict[str, float], dict[str, str]]:
        """Return values that the device measured of its last stream, as `conditions` does."""
        return stream_conditions(self._roles[role], self._patience.answer_s)

    def make_safe(self) -> tuple[SafetyReport, ...]:
        """Make every device safe, independently of the others; never raises.

        Idempotent. First come, one after another, the drives and devices that the given order
        names; then all others at the same time, cyclically moving ones begun first, so that none
        waits for one that is slow or hangs. Those of the order that are not safe are tried again
        with them. A drive is safe once it is read back at its safe value. A call that exceeded its
        time limit is waited for: if it returns, its device is made safe again, otherwise it is not
        safe. Safe devices are removed from the marker of the energised rig.
        """
        answer_s = self._patience.answer_s
        self._paused.clear()
        self._set_points.clear()
        self.cycles.stop()
        # Before it: a call that returns while the rig is made safe may undo that too.
        late_calls = {role.name: late for role in self._roles.values() if (late := role.late)}
        reports: dict[tuple[str, str], SafetyReport] = {}

        def make_place_safe(role: str, drive: str = "", *, by_drive: bool = True) -> SafetyReport:
            device, caller = self.devices[role], self._roles[role].caller
            connected = by_drive and role in self._connected
            return make_safe(role, drive, device, caller, answer_s, connected=connected)

        def settle(role: str) -> None:
            report = reports.get((role, ""))
            if report is None or not report.safe:
                report = make_place_safe(role)
            if late := late_calls.get(role):
                report = after_late_call(report, late, partial(make_place_safe, role))
            reports[role, ""] = report

        named_in_order = set(map(str, self._safe_order))
        places = [
            (role, drive)
            for role, drive in safe_places(self._safe_order, self.devices)
            # Drives of a device that never answered are left to its own `make_safe`.
            if not drive or role in self._connected
        ]
        for role, drive in places:
            if drive or role in named_in_order:
                reports[role, drive] = make_place_safe(role, drive, by_drive=False)
        roles = [role for role, drive in places if not drive]
        inline = [role for role in roles if self._roles[role].is_inline]
        settle_all([role for role in roles if role not in inline], inline, settle)
        ordered = tuple(reports.get(place) or interrupted(*place) for place in places)
        if self._marks is not None:
            safe = [report.role for report in ordered if not report.drive and report.safe]
            self._marks.confirm(safe)
        return ordered

    def close(self) -> None:
        """Close every device; then raise the first error, with the others."""
        do_all(*(partial(self._close, role) for role in self._roles.values()))

    def _close(self, role: Role) -> None:
        try:
            with role.named("close"):
                role.caller.call_urgently("close", role.device.close, self._patience.answer_s)
        finally:
            role.caller.stop()

    def _connect(self, role: str) -> Identity:
        limit_s, connect = self._patience.connect_s, self.devices[role].connect
        # The driver keeps the limit itself; twice that ends one that does not.
        longest_s = math.inf if math.isinf(self._patience.answer_s) else 2 * limit_s
        identity = self._call(role, "connect", lambda: connect(limit_s), longest_s)
        self._connected.add(role)
        # After it counts as connected: also a device that is refused is left safe.
        check_identity(role, identity)
        identity = plain_identity(identity)
        self._roles[role].refresh()
        self._drives.clear()
        self._channels.clear()
        return identity

    def _standing(self, member: Member) -> float:
        if member in self._set_points:
            return self._set_points[member]
        position = self.read_back(member.role, member.name)
        if not math.isfinite(position):  # compared with any limit it would seem to be within
            raise DeviceRejectedError(
                f"{member.role}: {member.name} reads back {position:g}: its position is unknown"
            )
        return position

    def _connected_drive(self, role: str, drive: str) -> ConnectedDrive:
        connected = self._drives.get((role, drive))
        if connected is None:
            connected = ConnectedDrive(self._roles[role], drive, self._shared)
            self._drives[role, drive] = connected
        return connected

    def _move(self, role: str, what: str, function: Callable[[], _T]) -> _T:
        """Call the function that moves all drives of a device."""
        longest_s = sum(info.longest_s for info in self.devices[role].drives)
        limit_s = self._patience.answer_s + longest_s
        return self._call(role, what, self._roles[role].moving(what, function, limit_s), limit_s)

    def _call(
        self, role: str, what: str, function: Callable[[], _T], timeout_s: float | None = None
    ) -> _T:
        limit_s = self._patience.answer_s if timeout_s is None else timeout_s
        return self._roles[role].call(what, function, limit_s)
