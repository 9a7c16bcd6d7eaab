"""Devices and their optional abilities.

A device is a small synchronous object. Its constructor does no I/O, so that a plan can read its
channels and drives without touching the rig. All values are in the unit of the ChannelInfo or
DriveInfo, which is the coherent SI unit of its dimension.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, runtime_checkable

from rigrunner.api.errors import DeviceRejectedError, PluginError
from rigrunner.api.quantity import legible

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from datetime import datetime
    from pathlib import Path

    from rigrunner.api.data import Block
    from rigrunner.api.readings import Reading, ReadingKind

_Answer = TypeVar("_Answer")


class Clock(Protocol):
    """The clock of devices and engine; simulated time passes as fast as possible."""

    def monotonic_s(self) -> float:
        """Return seconds since an arbitrary start; never decreases."""
        ...

    def utc(self) -> datetime:
        """Return the date and time, timezone-aware, in UTC."""
        ...

    def sleep(self, seconds: float) -> None:
        """Wait for a duration."""
        ...


class StopToken(Protocol):
    """Tells whether the run has to stop; checked between blocks."""

    def is_set(self) -> bool:
        """Return True once the run has to stop."""
        ...


class MakeDevice(Protocol):
    """Makes a device of any plugin."""

    def __call__(self, plugin: str, settings: Mapping[str, Any], /, part: str = "") -> Device:
        """Return the device, in the same role or in its `part`, 'role/part'; raise PluginError."""
        ...


def _no_other_device(plugin: str, settings: Mapping[str, Any], /, part: str = "") -> Device:  # noqa: ARG001  (the Protocol's)
    raise PluginError(f"the device '{plugin}' cannot be created here", hint="name it in a station")


class Wire(Protocol):
    """Passes each exchange with an instrument, so that it can be recorded and replayed."""

    def exchange(self, request: str, perform: Callable[[], _Answer]) -> _Answer:
        """Return the result of `perform`, or the recorded answer.

        `request` describes the exchange with the same words each time, such as 'query MEAS:TORQ?'.
        An answer is None, a bool, a number, a text, bytes, an array of float64 of shape (n,), or a
        list of these. `perform` raises a DeviceError if the exchange fails. It keeps opened
        connections to itself, since it is not called in a replay.
        """
        ...


class DirectWire:
    """A Wire that records nothing."""

    def exchange(self, request: str, perform: Callable[[], _Answer]) -> _Answer:  # noqa: ARG002  (the Protocol's)
        """Return the result of `perform`."""
        return perform()


class DeviceLog(Protocol):
    """Takes log messages of a driver, for run.log and the run file.

    Arguments are formatted by `%`, as by loggers of the standard library. Thread-safe; never
    raises.
    """

    def info(self, text: str, *values: object) -> None:
        """Log useful information; it becomes a Note of the run."""
        ...

    def warning(self, text: str, *values: object) -> None:
        """Log a possible cause of wrong results; it becomes an Alarm."""
        ...

    def error(self, text: str, *values: object) -> None:
        """Log an error; it becomes an Alarm. It does not replace raising a DeviceError."""
        ...


class SilentLog:
    """A DeviceLog that drops all messages."""

    def info(self, text: str, *values: object) -> None:
        """Drop the message."""

    def warning(self, text: str, *values: object) -> None:
        """Drop the message."""

    def error(self, text: str, *values: object) -> None:
        """Drop the message."""


@dataclass(frozen=True)
class Patience:
    """Time limits for calls of a device that may block, beyond the time that its drives need."""

    connect_s: float = 10.0
    answer_s: float = 10.0


@dataclass(frozen=True)
class DeviceContext:
    """What a device receives in addition to its settings."""

    role: str
    clock: Clock
    folder: Path
    """The folder of the station file, the base of relative paths in settings."""
    make: MakeDevice = _no_other_device
    """Makes the parts of a composite device, whose settings are MadeOfOthers."""
    wire: Wire = field(default_factory=DirectWire)
    """For the exchanges of a device whose record is `wired`."""
    patience: Patience = field(default_factory=Patience)
    """Time limits for each part of a composite device."""
    log: DeviceLog = field(default_factory=SilentLog)
    """Log for run.log and the run file."""


@dataclass(frozen=True)
class Identity:
    """The identity of the instrument that answered."""

    maker: str
    model: str
    serial: str
    firmware: str = ""
    simulated: bool = False
    parts: Mapping[str, Identity] = field(default_factory=dict)
    """The identity of each part of a composite device."""


@dataclass(frozen=True)
class ChannelInfo:
    """One quantity that a device measures."""

    name: str
    unit: str
    long_name: str
    streams: bool = True
    """Whether a Streaming device streams the channel; False: it is only read."""
    shown_in: str = ""
    """The unit in which it is displayed, such as °C for K; '' for `unit`."""


@dataclass(frozen=True)
class ReadingInfo:
    """A reading that is not a number: a text, a yes or no, an array."""

    name: str
    kind: ReadingKind
    long_name: str
    unit: str = ""
    """The coherent SI unit of the numbers of an array."""


@dataclass(frozen=True)
class DriveInfo:
    """One quantity that a device sets, with the limits within which it may be set."""

    name: str
    unit: str
    long_name: str
    minimum: float
    maximum: float
    rate_per_s: float | None = None
    """Rate of change towards the set-point, in unit per second; None: at once."""
    sets_cycle_frequency: bool = False
    """True for the drive that sets the frequency of the cyclic motion."""
    safe_value: float = 0.0
    tolerance: float | None = None
    """Allowed deviation of the read-back from the set-point; None: 1 % of the range."""
    settle_s: float = 0.0
    """Longest settling time, in addition to the time that the rate gives."""

    @property
    def allowed_deviation(self) -> float:
        """Allowed deviation of the read-back from the set-point."""
        if self.tolerance is not None:
            return self.tolerance
        return 0.01 * (self.maximum - self.minimum)

    @property
    def range_text(self) -> str:
        """The range in words: '0 to 3000 N', '300 nm to 1.1 µm'."""
        low, high = (legible(value, self.unit) for value in (self.minimum, self.maximum))
        number, _, symbol = low.partition(" ")
        return f"{number if high.partition(' ')[2] == symbol else low} to {high}"

    @property
    def longest_s(self) -> float:
        """Longest time from one end of the range to the other, settling included."""
        moving_s = (self.maximum - self.minimum) / self.rate_per_s if self.rate_per_s else 0.0
        return moving_s + self.settle_s


@runtime_checkable
class Device(Protocol):
    """The methods that every device must have."""

    @property
    def channels(self) -> Sequence[ChannelInfo]:
        """The channels that can be read or streamed."""
        ...

    @property
    def drives(self) -> Sequence[DriveInfo]:
        """The drives that can be set."""
        ...

    @property
    def non_blocking(self) -> bool:
        """True if no call can hang: calls are then made inline, without a thread.

        No call of such a device waits for hardware, or every call has a time-out of its own.
        """
        ...

    def connect(self, timeout_s: float) -> Identity:
        """Open the connection and identify the instrument; raise a DeviceError."""
        ...

    def make_safe(self) -> Mapping[str, float]:
        """Set every drive to its safe value and return the read-backs.

        Idempotent; can be called in any state, connected or not.
        """
        ...

    def close(self) -> None:
        """Close the connection; idempotent, can be called in any state."""
        ...


@runtime_checkable
class Readable(Protocol):
    """Reads single values of channels."""

    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        """Return the present value of each channel."""
        ...


@runtime_checkable
class ReadableInPlaces(Readable, Protocol):
    """Can be read at certain set-points alone, as a table of values can."""

    def unreadable_at(self, set_points: Mapping[str, float]) -> DeviceRejectedError | None:
        """Return why it cannot be read at these set-points of its drives; None if it can.

        Asked before it is connected, so that a plan is refused before anything moves.
        """
        ...


@runtime_checkable
class Observing(Protocol):
    """Reads values that are not numbers. Their names differ from those of the channels."""

    @property
    def readings(self) -> Sequence[ReadingInfo]:
        """The readings; known before the device is connected."""
        ...

    def observe(self, readings: Sequence[str]) -> Mapping[str, Reading]:
        """Return the present readings: a str, a bool, or a tuple of finite numbers."""
        ...


@runtime_checkable
class Settable(Protocol):
    """Has drives that can be set."""

    def set(self, drive: str, value: float) -> None:
        """Set the drive and return when the set-point is reached; raise a DeviceError."""
        ...

    def read_back(self, drive: str) -> float:
        """Return the actual value of the drive."""
        ...


@runtime_checkable
class Approaching(Settable, Protocol):
    """Reaches a set-point over time, while the run continues to monitor the rig.

    The engine calls `begin` and then polls `arrived`: a stop, an interlock and the time limit of
    the step take effect while the drive moves. `set` does both.
    """

    def begin(self, drive: str, value: float) -> None:
        """Give the drive a new set-point and return at once; raise a DeviceError."""
        ...

    def arrived(self, drive: str) -> bool:
        """Return whether the drive has reached its set-point."""
        ...


@runtime_checkable
class Streaming(Protocol):
    """Records channels that share one clock."""

    @property
    def sample_rate_hz(self) -> float:
        """Samples per second and channel."""
        ...

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        """Yield gapless blocks until the duration has passed or the token is set."""
        ...


@runtime_checkable
class KnowsStream(Streaming, Protocol):
    """Measures values of a stream that are stored with its recording."""

    def stream_conditions(self) -> Mapping[str, tuple[float, str]]:
        """Return values and SI units of the last stream, by name, such as 'angle_alignment_u'.

        They are stored as conditions of the recording.
        """
        ...


@runtime_checkable
class Pausable(Protocol):
    """Can pause and resume."""

    def pause(self) -> None:
        """Stop all motion that can be resumed; return at standstill."""
        ...

    def resume(self) -> None:
        """Bring every drive back to where it was when paused; return when it is there."""
        ...


@runtime_checkable
class CountsStreams(Protocol):
    """Varies each stream at the same set-points, as a simulator does with its noise."""

    def continue_after(self, streams: Sequence[Mapping[str, float]]) -> None:
        """Count what was streamed before the program was started again: set-points by drive."""
        ...


@runtime_checkable
class KnowsTruth(Protocol):
    """A simulator with true values, which are stored apart and never passed to the analysis."""

    def truth(self) -> Mapping[str, float]:
        """Return the true values of the last stream, such as 'temperature_k'."""
        ...
