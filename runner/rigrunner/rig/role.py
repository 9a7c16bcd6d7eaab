"""One device in its role: its abilities, and calls of it."""

from __future__ import annotations

from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from rigrunner.api.calling import InlineCaller, MovingCalls, ThreadCaller
from rigrunner.api.errors import (
    DeviceError,
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
)
from rigrunner.api.texts import visible
from rigrunner.rig.pulse import PulseCaller

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.api.calling import Caller, MovingCall
    from rigrunner.api.devices import Device, DriveInfo
    from rigrunner.rig.pulse import Pulse

_T = TypeVar("_T")


class Role:
    """A device and its caller. Every DeviceError names the role.

    Abilities and drives are looked up once, and again when connected: an `isinstance` check of a
    Protocol takes longer than setting a fast drive.
    """

    def __init__(self, name: str, device: Device, pulse: Pulse | None = None) -> None:
        self.name = name
        self.device = device
        self.is_inline = device.non_blocking
        """Whether its calls are made in the thread that asks for them."""
        self.caller: Caller = InlineCaller() if self.is_inline else ThreadCaller(name)
        if pulse is not None and not self.is_inline:
            self.caller = PulseCaller(self.caller, pulse)
        self._abilities: dict[type[Any], object] = {}
        self._drives: dict[str, DriveInfo] = {}
        self._moving = MovingCalls()

    @property
    def late(self) -> MovingCall | None:
        """The call that moves a drive, exceeded its time limit, and has not returned."""
        return self._moving.late

    def moving(self, what: str, function: Callable[[], _T], timeout_s: float) -> Callable[[], _T]:
        """Return the next call of the same function, whose return is tracked."""
        return function if self.is_inline else self._moving.next(what, function, timeout_s)

    def refresh(self) -> None:
        """Look up the abilities again."""
        self._abilities.clear()
        self._drives.clear()

    def able(self, ability: type[_T]) -> _T | None:
        """Return the device if it has the ability."""
        if ability not in self._abilities:
            self._abilities[ability] = self.device if isinstance(self.device, ability) else None
        return self._abilities[ability]  # type: ignore[return-value]  # checked by isinstance

    def need(self, ability: type[_T]) -> _T:
        """Return the device; raise DeviceRejectedError if it does not have the ability."""
        device = self._abilities.get(ability) or self.able(ability)
        if device is None:
            raise DeviceRejectedError(f"{self.name}: the device is not {ability.__name__.lower()}")
        return device  # type: ignore[return-value]  # checked by isinstance

    def drive(self, name: str) -> DriveInfo:
        """Return a drive; raise DeviceRejectedError."""
        if not self._drives:
            self._drives.update((info.name, info) for info in self.device.drives)
        if name not in self._drives:
            raise DeviceRejectedError(
                f"{self.name}: there is no drive '{name}'",
                hint=f"there are: {', '.join(self._drives)}",
            )
        return self._drives[name]

    def call(
        self, what: str, function: Callable[..., _T], timeout_s: float, *arguments: object
    ) -> _T:
        """Return the result of the function; raise a DeviceError, also for a time-out."""
        try:
            if self.is_inline:  # as its caller does, but without the time of its call
                return function(*arguments)
            return self.caller.call(what, partial(function, *arguments), timeout_s)
        except BaseException as error:
            self.name_error(error, what)
            raise

    @contextmanager
    def named(self, what: str = "a call") -> Iterator[None]:
        """Add the role to errors of several calls."""
        try:
            yield
        except BaseException as error:
            self.name_error(error, what)
            raise

    def name_error(self, error: BaseException, what: str) -> None:
        """Add the role to the error; convert exceptions that would end the program.

        Built-in exceptions with the meaning of a DeviceError are converted too. A driver that calls
        `sys.exit`, or whose asyncio task was cancelled, cannot end a run silently.
        """
        if isinstance(error, DeviceError):
            error.message = visible(f"{self.name}: {error.message}")
            error.hint = visible(error.hint)
        elif isinstance(error, TimeoutError):
            raise DeviceTimeoutError(
                visible(f"{self.name}: {_failure_text(what, error, 'no answer in time')}")
            ) from error
        elif isinstance(error, OSError):
            raise DeviceLostError(
                visible(f"{self.name}: {_failure_text(what, error, 'the connection broke')}")
            ) from error
        elif isinstance(error, Exception):
            error.add_note(f"in the device of the role '{self.name}': {what}")
        elif not isinstance(error, KeyboardInterrupt):
            raised = f"{type(error).__name__}({error})"
            raise RuntimeError(f"{self.name}: '{what}' raised {raised}") from error  # noqa: TRY004  (no type is checked)


def _failure_text(what: str, error: OSError, meaning: str) -> str:
    """Return what failed, what that means, and the message of the driver, if any."""
    return f"{what}: {meaning}{f' ({error})' if str(error) else ''}"
