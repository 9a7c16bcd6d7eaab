"""Moving drives: when one has arrived, and how to wait for it."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any, Protocol, SupportsFloat, TypeVar

from rigrunner.api.errors import DeviceRejectedError, DeviceTimeoutError
from rigrunner.api.member import Member
from rigrunner.api.quantity import legible

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rigrunner.api.devices import Approaching, Clock, DriveInfo

_T = TypeVar("_T")
_POLL_S = 0.05
"""Interval at which a moving drive is polled."""


class Call(Protocol):
    """Calls a device, with a purpose and a function."""

    def __call__(self, what: str, function: Callable[[], _T], /) -> _T:
        """Return the result of the function; raise a DeviceError."""
        ...


def as_number(value: object) -> float:
    """Return a number of a driver, such as a NumPy scalar, as float; raise DeviceRejectedError."""
    # Not isinstance: numpy.float64 is a float as well, and becomes a plain one below.
    if type(value) is float:
        return value
    # NumPy would drop an imaginary part with a mere warning.
    is_complex = getattr(getattr(value, "dtype", None), "kind", "") == "c"
    if isinstance(value, SupportsFloat) and not is_complex:
        with suppress(TypeError, ValueError, OverflowError):  # such as an array of several
            return float(value)
    raise DeviceRejectedError(f"the driver gave {value!r}, which is not a number")


def agrees(info: DriveInfo, actual: float, value: float) -> bool:
    """Return whether the actual value of a drive is its set-point within the tolerance."""
    return abs(actual - value) <= info.allowed_deviation


def away_from_safe(
    role: str, drives: Iterable[DriveInfo], set_points: Mapping[Member, float]
) -> list[str]:
    """Return, as text, which drives are not at their safe value; set-points by 'role.drive'."""
    return [
        f"{info.name} stays at {legible(value, info.unit)}"
        for info in drives
        if (value := set_points.get(Member(role, info.name))) not in {None, info.safe_value}
    ]


def approach(
    device: Approaching,
    info: DriveInfo,
    value: float,
    *,
    call: Call,
    move: Call,
    clock: Clock,
    limit_s: float,
    meanwhile: Callable[[], Any],
) -> None:
    """Set a drive and wait until it has arrived; raise DeviceTimeoutError.

    `move` makes the call that moves the drive, `call` all others. `meanwhile` is called repeatedly;
    its exceptions end the wait.
    """
    name, until_s = info.name, clock.monotonic_s() + limit_s
    move(f"set {name}", lambda: device.begin(name, value))
    while not call(f"read back {name}", lambda: device.arrived(name)):
        if clock.monotonic_s() >= until_s:
            actual = as_number(call(f"read back {name}", lambda: device.read_back(name)))
            raise DeviceTimeoutError(
                f"{name} reads back {actual:g} {info.unit} after {limit_s:g} s,"
                f" set to {value:g} {info.unit}",
                hint="does it move? see its rate, settling time and tolerance",
            )
        meanwhile()
        clock.sleep(_POLL_S)
