"""What a device is, and the abilities that it may have.

A device is a small synchronous object. Its constructor does no I/O, so that a plan can ask for its
channels and drives without touching the rig. All values are in the unit that the ChannelInfo or
DriveInfo names, which is the coherent SI unit of its dimension.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, runtime_checkable

from rigrunner.api.errors import PluginError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from datetime import datetime
    from pathlib import Path

    from rigrunner.api.data import Block
    from rigrunner.api.readings import Reading, ReadingKind

_Answer = TypeVar("_Answer")


class Clock(Protocol):
    """Time as a device and the engine see it; simulated time passes as fast as it can."""

    def monotonic_s(self) -> float:
        """Return seconds since an arbitrary start; never goes back."""
        ...

    def utc(self) -> datetime:
        """Return the date and time, timezone-aware, in UTC."""
        ...

    def sleep(self, seconds: float) -> None:
        """Let that much time pass."""
        ...


class StopToken(Protocol):
    """Says whether the run is asked to stop; looked at between blocks."""

    def is_set(self) -> bool:
        """Return True once the run is to stop."""
        ...


class MakeDevice(Protocol):
    """Makes a device of any plugin."""

    def __call__(self, plugin: str, settings: Mapping[str, Any], /, part: str = "") -> Device:
        """Return the device, in the same role or in its `part`, 'role/part'; raise PluginError."""
        ...


def _no_other_device(plugin: str, settings: Mapping[str, Any], /, part: str = "") -> Device:  # noqa: ARG001  (the Protocol's)
    raise PluginError(f"the device '{plugin}' cannot be made here", hint="name it in a station")


class Wire(Protocol):
    """Carries each exchange with an instrument, so that it can be saved and played back."""

    def exchange(self, request: str, perform: Callable[[], _Answer]) -> _Answer:
        """Return what `perform` does, or what it answered when the exchange was saved.

        The request says what is asked in words that are the same each time, such as
        'query MEAS:TORQ?'. An answer is None, a bool, a number, a text, bytes, an array of float64
        of shape (n,), or a list of such. `perform` raises a DeviceError where the exchange fails,
        and keeps whatever it opens to itself: of a played-back exchange it is not called.
        """
        ...


class DirectWire:
    """A Wire that keeps nothing."""

    def exchange(self, request: str, perform: Callable[[], _Answer]) -> _Answer:  # noqa: ARG002  (the Protocol's)
        """Return what `perform` does."""
        return perform()


class DeviceLog(Protocol):
    """Takes messages of a driver, for run.log and the run's record.

    As of a logger of the standard library, values are put into the text by `%`. Any thread may
    call it. It never raises.
    """

    def info(self, text: str, *values: object) -> None:
        """Tell something that is good to know; it becomes a Note of the run."""
        ...

    def warning(self, text: str, *values: object) -> None:
        """Tell something that may have to do with a wrong result; it becomes an Alarm."""
        ...

    def error(self, text: str, *values: object) -> None:
        """Tell something that went wrong; it becomes an Alarm. Does not replace a DeviceError."""
        ...


class SilentLog:
    """A DeviceLog that keeps nothing."""

    def info(self, text: str, *values: object) -> None:
        """Keep nothing."""

    def warning(self, text: str, *values: object) -> None:
        """Keep nothing."""

    def error(self, text: str, *values: object) -> None:
        """Keep nothing."""


@dataclass(frozen=True)
class Patience:
    """How long a device that may block is waited for, beyond the time that its drives need."""

    connect_s: float = 10.0
    answer_s: float = 10.0


@dataclass(frozen=True)
class DeviceContext:
    """What a device receives in addition to its settings."""

    role: str
    clock: Clock
    folder: Path
    """The folder of the station file, to which relative paths in settings refer."""
    make: MakeDevice = _no_other_device
    """For a device that is made of others, whose settings are MadeOfOthers."""
    wire: Wire = field(default_factory=DirectWire)
    """For the exchanges of a device whose record says that it is `wired`."""
    patience: Patience = field(default_factory=Patience)
    """For a device that is made of others: how long it waits for each of them."""
    log: DeviceLog = field(default_factory=SilentLog)
    """For what run.log and the run's record are to tell of the device, such as a warning."""


@dataclass(frozen=True)
class Identity:
    """The identity of the instrument that answers."""

    maker: str
    model: str
    serial: str
    firmware: str = ""
    simulated: bool = False
    parts: Mapping[str, Identity] = field(default_factory=dict)
    """Who answers in each part of a device that is made of several."""


@dataclass(frozen=True)
class ChannelInfo:
    """One quantity that a device measures."""

    name: str
    unit: str
    long_name: str
    streams: bool = True
    """Whether a device that is Streaming streams it; False: it is only read."""
    shown_in: str = ""
    """The unit in which people see it, such as °C for K; '' for `unit`."""


@dataclass(frozen=True)
class ReadingInfo:
    """A reading that is not a number: a text, a yes or no, an array."""

    name: str
    kind: ReadingKind
    long_name: str
    unit: str = ""
    """Of an array: the coherent SI unit of its numbers."""


@dataclass(frozen=True)
class DriveInfo:
    """One quantity that a device sets, with the limits within which it may be set."""

    name: str
    unit: str
    long_name: str
    minimum: float
    maximum: float
    rate_per_s: float | None = None
    """How fast the quantity moves towards its set-point, in unit per second; None: at once."""
    sets_cycle_frequency: bool = False
    """True for the drive whose value is the frequency of the cyclic motion."""
    safe_value: float = 0.0
    tolerance: float | None = None
    """How far the read-back may be from the set-point; None: 1 % of the range."""
    settle_s: float = 0.0
    """How long it may take until it stands, beyond what the rate says."""

    @property
    def allowed_deviation(self) -> float:
        """How far the read-back may be from the set-point."""
        if self.tolerance is not None:
            return self.tolerance
        return 0.01 * (self.maximum - self.minimum)

    @property
    def longest_s(self) -> float:
        """How long it may take from one end of its range to the other until it stands."""
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
        """True where no call can hang: then it is called inline, without a thread.

        No call of such a device waits for hardware, or each one gives up by itself in time.
        """
        ...

    def connect(self, timeout_s: float) -> Identity:
        """Open the connection and identify; raise a DeviceError."""
        ...

    def make_safe(self) -> Mapping[str, float]:
        """Bring every drive to its safe value and return what was read back from each.

        Idempotent, callable in any state, connected or not.
        """
        ...

    def close(self) -> None:
        """Release the connection; idempotent, callable in any state."""
        ...


@runtime_checkable
class Readable(Protocol):
    """Gives single values of channels."""

    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        """Return the present value of each channel."""
        ...


@runtime_checkable
class Observing(Protocol):
    """Tells what is not a number. The names are none of its channels."""

    @property
    def readings(self) -> Sequence[ReadingInfo]:
        """What it can tell; known before it is connected."""
        ...

    def observe(self, readings: Sequence[str]) -> Mapping[str, Reading]:
        """Return each as it is now: a str, a bool, or a tuple of finite numbers."""
        ...


@runtime_checkable
class Settable(Protocol):
    """Has drives that can be set."""

    def set(self, drive: str, value: float) -> None:
        """Give the drive a new set-point; return when it is reached; raise a DeviceError."""
        ...

    def read_back(self, drive: str) -> float:
        """Return the drive's actual value."""
        ...


@runtime_checkable
class Approaching(Settable, Protocol):
    """Reaches a set-point over time, while the run continues to monitor the rig.

    The engine calls `begin` and then asks `arrived` until it is so: a stop, an interlock and the
    step's time limit hold while the drive is on its way. `set` does both.
    """

    def begin(self, drive: str, value: float) -> None:
        """Give the drive a new set-point and return at once; raise a DeviceError."""
        ...

    def arrived(self, drive: str) -> bool:
        """Say whether the drive has reached its set-point."""
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
        """Stop what moves, as far as it can be gone on with; return when it stands."""
        ...

    def resume(self) -> None:
        """Bring every drive back to where it was when paused; return when it is there."""
        ...


@runtime_checkable
class CountsStreams(Protocol):
    """Varies each stream at the same set-points, as a simulator does with its noise."""

    def continue_after(self, streams: Sequence[Mapping[str, float]]) -> None:
        """Count what was streamed before the program was started anew: set-points by drive."""
        ...


@runtime_checkable
class KnowsTruth(Protocol):
    """A simulator that knows what no instrument can: kept apart, never shown to the analysis."""

    def truth(self) -> Mapping[str, float]:
        """Return the true values that held in the last stream, such as 'starting_torque_nm'."""
        ...
