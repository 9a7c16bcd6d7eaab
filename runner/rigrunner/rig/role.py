"""One device in its role: what it can do, and how it is called."""

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
from rigrunner.rig.pulse import NotedCaller

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.api.calling import Caller, MovingCall
    from rigrunner.api.devices import Device, DriveInfo
    from rigrunner.rig.pulse import Pulse

_T = TypeVar("_T")


class Role:
    """A device, and who calls it. Every DeviceError that leaves it names the role.

    What the device can do and which drives it has is looked up once, and anew when it is connected:
    to ask whether something is of a Protocol takes longer than to set a drive that does not wait.
    """

    def __init__(self, name: str, device: Device, pulse: Pulse | None = None) -> None:
        self.name = name
        self.device = device
        self._inline = device.non_blocking
        self.caller: Caller = InlineCaller() if self._inline else ThreadCaller(name)
        if pulse is not None and not self._inline:
            self.caller = NotedCaller(self.caller, pulse)
        self._abilities: dict[type[Any], object] = {}
        self._drives: dict[str, DriveInfo] = {}
        self._moving = MovingCalls()

    @property
    def late(self) -> MovingCall | None:
        """The call that moves a drive and was given up, if it has not come back."""
        return self._moving.late

    def moving(self, what: str, function: Callable[[], _T], timeout_s: float) -> Callable[[], _T]:
        """Return what does the same, to be called next: that it has returned is kept track of."""
        return function if self._inline else self._moving.next(what, function, timeout_s)

    def look_anew(self) -> None:
        """Forget what the device could do before it was connected."""
        self._abilities.clear()
        self._drives.clear()

    def able(self, ability: type[_T]) -> _T | None:
        """Return the device if it has that ability."""
        if ability not in self._abilities:
            self._abilities[ability] = self.device if isinstance(self.device, ability) else None
        return self._abilities[ability]  # type: ignore[return-value]  # isinstance said so

    def need(self, ability: type[_T]) -> _T:
        """Return the device; raise DeviceRejectedError if it has not that ability."""
        device = self._abilities.get(ability) or self.able(ability)
        if device is None:
            raise DeviceRejectedError(f"{self.name}: the device is not {ability.__name__.lower()}")
        return device  # type: ignore[return-value]  # isinstance said so

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
        """Return what the function returns; raise a DeviceError, a time-out among them."""
        try:
            if self._inline:  # as its caller does, without what a call of that takes
                return function(*arguments)
            return self.caller.call(what, partial(function, *arguments), timeout_s)
        except BaseException as error:
            self.name_error(error, what)
            raise

    @contextmanager
    def named(self, what: str = "a call") -> Iterator[None]:
        """Let the errors of several calls name the role."""
        try:
            yield
        except BaseException as error:
            self.name_error(error, what)
            raise

    def name_error(self, error: BaseException, what: str) -> None:
        """Let the error name the role; raise another one for what would end the program.

        The errors of Python that say what a DeviceError says become one. A driver that calls
        `sys.exit`, or whose asyncio task was cancelled, ends no run in silence.
        """
        if isinstance(error, DeviceError):
            error.message = f"{self.name}: {error.message}"
        elif isinstance(error, TimeoutError):
            raise DeviceTimeoutError(
                f"{self.name}: {_told(what, error, 'no answer in time')}"
            ) from error
        elif isinstance(error, ConnectionError):
            raise DeviceLostError(
                f"{self.name}: {_told(what, error, 'the connection broke')}"
            ) from error
        elif isinstance(error, Exception):
            error.add_note(f"in the device of the role '{self.name}': {what}")
        elif not isinstance(error, KeyboardInterrupt):
            raised = f"{type(error).__name__}({error})"
            raise RuntimeError(f"{self.name}: '{what}' raised {raised}") from error  # noqa: TRY004  (no type is checked)


def _told(what: str, error: OSError, meaning: str) -> str:
    """Return what failed, what that means, and what the driver said of it, if anything."""
    return f"{what}: {meaning}{f' ({error})' if str(error) else ''}"
