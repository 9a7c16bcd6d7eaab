"""One drive of a connected device, with all looked up that stays so while it is connected."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, TypeVar

from rigrunner.api.devices import Approaching, Settable
from rigrunner.api.errors import DeviceRejectedError
from rigrunner.rig.drives import approach, as_number

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api.devices import Clock, Patience
    from rigrunner.rig.role import Role
    from rigrunner.station.drive_rules import DriveRules

_T = TypeVar("_T")


class HeldDrive:
    """Sets a drive and reads it back; raises DeviceErrors that name the role."""

    def __init__(self, role: Role, name: str, rules: DriveRules, patience: Patience) -> None:
        """Look up; raise DeviceRejectedError if there is no such drive, or it cannot be set."""
        self.member = f"{role.name}.{name}"
        self.name = name
        self.info = role.drive(name)
        self.allowed = rules.narrowed(self.member, self.info)
        self.least, self.greatest = self.allowed.minimum, self.allowed.maximum
        own, rate_per_s = self.info.rate_per_s, self.allowed.rate_per_s
        self.led_rate_per_s = None if rate_per_s == own else rate_per_s
        """How fast the drive is to be led, as the station says; None: it moves by itself."""
        self._role = role
        self._device = role.need(Settable)  # type: ignore[type-abstract]  # a Protocol
        self._approaching = role.able(Approaching)  # type: ignore[type-abstract]  # a Protocol
        self._is_quick = role.device.non_blocking and self._approaching is None
        self._deviation = self.info.allowed_deviation
        self._answer_s = patience.answer_s
        self._limit_s = patience.answer_s + self.info.longest_s
        self._set, self._read_back = f"set {name}", f"read back {name}"

    def move(
        self, value: float, timeout_s: float | None, clock: Clock, meanwhile: Callable[[], None]
    ) -> float:
        """Set the drive, wait for it, and return what it reads back; that agrees."""
        if self._is_quick:
            actual = self._move_inline(value)
        else:
            self._move_and_wait(value, timeout_s, clock, meanwhile)
            actual = self.read_back()
        if not abs(actual - value) <= self._deviation:
            unit = self.info.unit
            raise DeviceRejectedError(
                f"{self._role.name}: {self.name} was set to {value:g} {unit}"
                f" but reads back {actual:g} {unit}",
                hint=f"allowed: within {self._deviation:g} {unit}",
            )
        return actual

    def _move_inline(self, value: float) -> float:
        """Set a drive whose calls do not wait, and read it back: two calls of the role in one."""
        what = self._set
        try:
            self._device.set(self.name, value)
            what = self._read_back
            actual = self._device.read_back(self.name)
        except BaseException as error:
            self._role.name_error(error, what)
            raise
        return actual if type(actual) is float else self._as_number(actual)

    def _move_and_wait(
        self, value: float, timeout_s: float | None, clock: Clock, meanwhile: Callable[[], None]
    ) -> None:
        limit_s = self._limit_s if timeout_s is None else timeout_s
        if self._approaching is None:
            set_it = partial(self._device.set, self.name, value)
            self._role.call(self._set, self._role.moving(self._set, set_it, limit_s), limit_s)
            return
        with self._role.named():
            approach(
                self._approaching,
                self.info,
                value,
                call=partial(self._role.caller.call, timeout_s=self._answer_s),
                move=self._begin,
                clock=clock,
                limit_s=limit_s,
                meanwhile=meanwhile,
            )

    def _begin(self, what: str, function: Callable[[], _T]) -> _T:
        """Call what begins to move the drive."""
        moving = self._role.moving(what, function, self._answer_s)
        return self._role.caller.call(what, moving, self._answer_s)

    def read_back(self) -> float:
        """Return where the drive is read back to stand."""
        actual = self._role.call(self._read_back, self._device.read_back, self._answer_s, self.name)
        return actual if type(actual) is float else self._as_number(actual)

    def _as_number(self, given: object) -> float:
        """Return what the driver gave, which is no float as of most drivers, as one."""
        with self._role.named():
            return as_number(given)
