"""One drive of a connected device, with everything that stays the same while it is connected."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from rigrunner.api.devices import Approaching, Settable
from rigrunner.api.errors import DeviceRejectedError
from rigrunner.api.member import Member
from rigrunner.rig.drives import approach, as_number

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api.devices import Clock, Patience
    from rigrunner.rig.cycles import CycleCount
    from rigrunner.rig.role import Role
    from rigrunner.rig_state import RigMarks
    from rigrunner.station.drive_rules import DriveRules

_T = TypeVar("_T")


@dataclass(frozen=True, eq=False)
class Shared:
    """What all drives of a rig share."""

    rules: DriveRules
    patience: Patience
    clock: Clock
    set_points: dict[Member, float]
    """Known set-points of drives, 'role.drive'."""
    standing: Callable[[Member], float]
    """Returns the set-point of a drive; reads it back if unknown."""
    cycles: CycleCount
    """Counts cycles of each drive that sets the frequency of a cyclic motion."""
    marks: RigMarks | None = None
    """Stores, for later processes, that a drive is energised."""


class ConnectedDrive:
    """Sets a drive and reads it back; raises DeviceErrors that name the role."""

    def __init__(self, role: Role, name: str, shared: Shared) -> None:
        """Look up the drive; raise DeviceRejectedError if it does not exist or cannot be set."""
        rules, patience = shared.rules, shared.patience
        self.member = Member(role.name, name)
        self.name = name
        self.info = role.drive(name)
        self._allowed = rules.narrowed(self.member, self.info)
        self._least, self._greatest = self._allowed.minimum, self._allowed.maximum
        drive_rate_per_s, rate_per_s = self.info.rate_per_s, self._allowed.rate_per_s
        self.led_rate_per_s = None if rate_per_s == drive_rate_per_s else rate_per_s
        """Rate at which to move the drive, from the station; None: it moves by itself."""
        self._rules, self._set_points = rules, shared.set_points
        self._standing, self._clock = shared.standing, shared.clock
        self._mark = shared.marks.before_set(role.name, self.info) if shared.marks else None
        self._cycles = shared.cycles if self.info.sets_cycle_frequency else None
        self._role = role
        self._device = role.need(Settable)  # type: ignore[type-abstract]  # a Protocol
        self._approaching = role.able(Approaching)  # type: ignore[type-abstract]  # a Protocol
        self._deviation = self.info.allowed_deviation
        self._answer_s = patience.answer_s
        self._limit_s = patience.answer_s + self.info.longest_s
        self._set, self._read_back = f"set {name}", f"read back {name}"

    def move(self, timeout_s: float | None, meanwhile: Callable[[], None], value: float) -> float:
        """Set the drive within its limits, wait, and return the read-back, which agrees.

        The value is the last argument, so that the others can be bound.
        """
        if self._rules.combinations or not self._least <= value <= self._greatest:
            self._rules.check(self.member, self._allowed, value, self._standing)
        self._set_points.pop(self.member, None)  # not known until it is read back
        # Before the command: a process that dies after it must not leave the rig unmarked.
        if self._mark is not None:
            self._mark(value)
        if self._cycles is not None:
            self._cycles.leave(self._role.name)
        self._move_and_wait(value, timeout_s, meanwhile)
        if self._cycles is not None:
            self._cycles.stand(self._role.name, value)
        actual = self.read_back()
        # Not written as ">": a read-back of NaN is no agreement.
        if not abs(actual - value) <= self._deviation:
            unit = self.info.unit
            raise DeviceRejectedError(
                f"{self._role.name}: {self.name} was set to {value:g} {unit}"
                f" but reads back {actual:g} {unit}",
                hint=f"allowed: within {self._deviation:g} {unit}",
            )
        self._set_points[self.member] = value
        return actual

    def _move_and_wait(
        self, value: float, timeout_s: float | None, meanwhile: Callable[[], None]
    ) -> None:
        limit_s = self._limit_s if timeout_s is None else timeout_s
        # `set` of such a device may wait until the drive has arrived: nothing can be polled.
        if self._approaching is None:
            set_drive = partial(self._device.set, self.name, value)
            self._role.call(self._set, self._role.moving(self._set, set_drive, limit_s), limit_s)
            return
        with self._role.named():
            approach(
                self._approaching,
                self.info,
                value,
                call=partial(self._role.caller.call, timeout_s=self._answer_s),
                move=self._begin,
                clock=self._clock,
                limit_s=limit_s,
                meanwhile=meanwhile,
            )

    def _begin(self, what: str, function: Callable[[], _T]) -> _T:
        """Call the function that starts to move the drive."""
        moving = self._role.moving(what, function, self._answer_s)
        return self._role.caller.call(what, moving, self._answer_s)

    def stands_at(self, actual: float, value: float) -> bool:
        """Return whether a read-back is the set-point within the tolerance of the drive."""
        return abs(actual - value) <= self._deviation

    def read_back(self) -> float:
        """Return the read-back of the drive."""
        return self._role.call(
            self._read_back, lambda: as_number(self._device.read_back(self.name)), self._answer_s
        )
