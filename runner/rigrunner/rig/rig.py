"""All devices of a station as one: connected together, made safe together, closed together."""

from __future__ import annotations

import math
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self, TypeVar

from rigrunner.api.devices import KnowsTruth, Readable, Settable, Streaming
from rigrunner.api.errors import DeviceError, DeviceRejectedError
from rigrunner.rig.worker import InlineCaller, ThreadCaller

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
    from types import TracebackType

    from rigrunner.api.data import Block
    from rigrunner.api.devices import Clock, Device, DriveInfo, Identity, StopToken
    from rigrunner.rig.worker import Caller

_T = TypeVar("_T")
_ATTEMPTS = 3
"""How often making one device safe is begun anew after an interrupt."""


@dataclass(frozen=True)
class Patience:
    """How long a device that may block is waited for, beyond the time that its drives need."""

    connect_s: float = 10.0
    answer_s: float = 10.0


@dataclass(frozen=True)
class SafetyReport:
    """Whether one device is safe: what was read back from its drives, and what speaks against."""

    role: str
    read_back: Mapping[str, float] = field(default_factory=dict)
    problems: tuple[str, ...] = ()

    @property
    def safe(self) -> bool:
        """True if every drive was read back at its safe value."""
        return not self.problems


class Rig:
    """The devices by role. Every DeviceError that leaves it names the role.

    Devices that declare themselves non-blocking are called inline; each other one from a thread of
    its own, where a call that takes too long is abandoned and raises DeviceTimeoutError.
    """

    def __init__(
        self, devices: Mapping[str, Device], clock: Clock, patience: Patience | None = None
    ) -> None:
        self.devices = dict(devices)
        self.clock = clock
        self._patience = patience or Patience()
        self._callers: dict[str, Caller] = {
            role: InlineCaller() if device.non_blocking else ThreadCaller(role)
            for role, device in self.devices.items()
        }

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.make_safe()
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

    def set(self, role: str, drive: str, value: float, timeout_s: float | None = None) -> float:
        """Set a drive within its limits and return the read-back; raise a DeviceError.

        The read-back must agree within the drive's tolerance. It is waited for as long as the drive
        needs and `Patience` adds, or for `timeout_s`.
        """
        info = self._drive(role, drive)
        if not info.minimum <= value <= info.maximum:
            raise DeviceRejectedError(
                f"{role}: {drive} cannot be set to {value:g} {info.unit}",
                hint=f"allowed: {info.minimum:g} to {info.maximum:g} {info.unit}",
            )
        device = self._able(role, Settable)  # type: ignore[type-abstract]  # a Protocol
        limit_s = self._patience.answer_s + travel_s(info) if timeout_s is None else timeout_s
        self._call(role, f"set {drive}", lambda: device.set(drive, value), limit_s)
        actual = self._call(role, f"read back {drive}", lambda: device.read_back(drive))
        if not agrees(info, actual, value):
            raise DeviceRejectedError(
                f"{role}: {drive} was set to {value:g} {info.unit}"
                f" but reads back {actual:g} {info.unit}",
                hint=f"allowed: within {tolerance(info):g} {info.unit}",
            )
        return actual

    def stream(
        self, role: str, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Generator[Block]:
        """Yield the blocks of one device until the duration has passed or the token is set."""
        device = self._able(role, Streaming)  # type: ignore[type-abstract]  # a Protocol
        timeout_s = self._patience.answer_s + duration_s
        blocks = self._call(
            role, "start the stream", lambda: iter(device.stream(channels, duration_s, stop))
        )
        try:
            while block := self._call(role, "stream", lambda: next(blocks, None), timeout_s):
                yield block
        finally:
            self._end_stream(role, blocks)

    def sample_rate_hz(self, role: str) -> float:
        """Return the sample rate of a device that streams."""
        device = self._able(role, Streaming)  # type: ignore[type-abstract]  # a Protocol
        return device.sample_rate_hz

    def truth(self, role: str) -> Mapping[str, float]:
        """Return what a simulator knows of its last stream; nothing of a real device."""
        device = self.devices[role]
        if not isinstance(device, KnowsTruth):
            return {}
        return self._call(role, "tell the truth", device.truth)

    def read(self, role: str, channels: Sequence[str]) -> dict[str, float]:
        """Return the present value of each channel by 'role.channel'; raise a DeviceError."""
        device = self._able(role, Readable)  # type: ignore[type-abstract]  # a Protocol
        return self._read(role, device, channels)

    def conditions(
        self, role: str, streamed: Sequence[str]
    ) -> tuple[dict[str, float], dict[str, str]]:
        """Read once all that can be read beside the channels that the role streams.

        Returns values and units by 'role.channel'.
        """
        values: dict[str, float] = {}
        units: dict[str, str] = {}
        for name, device in self.devices.items():
            if isinstance(device, Readable):
                busy = streamed if name == role else ()
                wanted = {info.name: info.unit for info in device.channels if info.name not in busy}
                values |= self._read(name, device, tuple(wanted))
                units |= {f"{name}.{channel}": unit for channel, unit in wanted.items()}
        return values, units

    def make_safe(self) -> tuple[SafetyReport, ...]:
        """Make every device safe, whatever happens to the others; never raises.

        Idempotent. A drive counts as safe once it is read back at its safe value.
        """
        return tuple(self._make_safe(role, device) for role, device in self.devices.items())

    def close(self) -> None:
        """Close every device; the first error is raised after all were tried."""
        errors: list[Exception] = []
        for role, device in self.devices.items():
            try:
                with _named(role):
                    self._callers[role].call_urgently(
                        "close", device.close, self._patience.answer_s
                    )
            except Exception as error:  # noqa: BLE001  (raised below, after the others)
                errors.append(error)
            self._callers[role].stop()
        if errors:
            raise errors[0]

    def _connect(self, role: str) -> Identity:
        limit_s, connect = self._patience.connect_s, self.devices[role].connect
        return self._call(role, "connect", lambda: connect(limit_s), 2 * limit_s)

    def _make_safe(self, role: str, device: Device) -> SafetyReport:
        timeout_s = self._patience.answer_s + sum(travel_s(info) for info in device.drives)
        for _ in range(_ATTEMPTS):
            try:
                read_back = dict(
                    self._callers[role].call_urgently("make safe", device.make_safe, timeout_s)
                )
                return SafetyReport(role, read_back, _unsafe(device, read_back))
            except KeyboardInterrupt:
                continue  # impatience must not leave a rig half safe
            except BaseException as error:  # noqa: BLE001  (reported; the next device has its turn)
                return SafetyReport(role, problems=(f"make safe failed: {_words(error)}",))
        return SafetyReport(role, problems=("make safe was interrupted from the keyboard",))

    def _end_stream(self, role: str, blocks: Iterator[Block]) -> None:
        close = getattr(blocks, "close", None)
        if close is not None:
            with suppress(DeviceError):  # a device that hangs has said so already
                self._call(role, "end the stream", close)

    def _read(self, role: str, device: Readable, channels: Sequence[str]) -> dict[str, float]:
        values = self._call(role, "read", lambda: device.read(channels))
        missing = [name for name in channels if not math.isfinite(values.get(name, math.nan))]
        if missing:
            raise DeviceRejectedError(f"{role}: no value was read of {', '.join(missing)}")
        return {f"{role}.{name}": float(values[name]) for name in channels}

    def _drive(self, role: str, drive: str) -> DriveInfo:
        drives = {info.name: info for info in self.devices[role].drives}
        if drive not in drives:
            raise DeviceRejectedError(
                f"{role}: there is no drive '{drive}'", hint=f"there are: {', '.join(drives)}"
            )
        return drives[drive]

    def _able(self, role: str, ability: type[_T]) -> _T:
        device = self.devices[role]
        if not isinstance(device, ability):
            raise DeviceRejectedError(f"{role}: the device is not {ability.__name__.lower()}")
        return device

    def _call(
        self, role: str, what: str, function: Callable[[], _T], timeout_s: float | None = None
    ) -> _T:
        limit_s = self._patience.answer_s if timeout_s is None else timeout_s
        with _named(role):
            return self._callers[role].call(what, function, limit_s)


def tolerance(info: DriveInfo) -> float:
    """Return how far a read-back may be from the set-point: declared, or 1 % of the range."""
    if info.tolerance is not None:
        return info.tolerance
    return 0.01 * (info.maximum - info.minimum)


def agrees(info: DriveInfo, actual: float, value: float) -> bool:
    """Return True if a drive's actual value is its set-point within the tolerance."""
    return abs(actual - value) <= tolerance(info)


def travel_s(info: DriveInfo) -> float:
    """Return how long the drive needs from one end of its range to the other, in seconds."""
    return (info.maximum - info.minimum) / info.rate_per_s if info.rate_per_s else 0.0


def _unsafe(device: Device, read_back: Mapping[str, float]) -> tuple[str, ...]:
    return tuple(
        f"{info.name} reads back {_value(info, read_back)}, safe is {info.safe_value:g} {info.unit}"
        for info in device.drives
        if not agrees(info, read_back.get(info.name, math.nan), info.safe_value)
    )


def _value(info: DriveInfo, read_back: Mapping[str, float]) -> str:
    return f"{read_back[info.name]:g} {info.unit}" if info.name in read_back else "nothing"


def _words(error: BaseException) -> str:
    return str(error) if isinstance(error, DeviceError) else f"{type(error).__name__}: {error}"


@contextmanager
def _named(role: str) -> Iterator[None]:
    try:
        yield
    except DeviceError as error:
        error.message = f"{role}: {error.message}"
        raise
