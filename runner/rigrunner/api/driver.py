"""The common part of all drivers: limits, settling, safe state, errors.

A driver derives from `Driver` and implements `open`, `shut`, `get` and `put`. All values are in the
unit of the ChannelInfo or DriveInfo, the coherent SI unit.
"""

from __future__ import annotations

from contextlib import contextmanager, suppress
from functools import partial
from typing import TYPE_CHECKING, ClassVar, TypeVar

from rigrunner.api.cleanup import do_all, noted_on
from rigrunner.api.devices import ChannelInfo, DriveInfo
from rigrunner.api.errors import (
    DeviceError,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
    PluginError,
)
from rigrunner.api.quantity import legible

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from rigrunner.api.devices import (
        Approaching,
        Clock,
        DeviceContext,
        Identity,
        ReadingInfo,
    )
    from rigrunner.api.readings import Reading

_T = TypeVar("_T")
_Info = TypeVar("_Info")
_SHORT_S = 5.0
"""Time limit of a reconnection where no other is known."""


def check_patience(timeout_s: float, context: DeviceContext) -> None:
    """Raise PluginError unless the time-out of an answer is shorter than that of the station.

    A device whose call has timed out at the station gets no further calls and cannot be made safe
    in order.
    """
    patience_s = context.patience.answer_s
    if timeout_s >= patience_s:
        raise PluginError(
            f"timeout: got {timeout_s:g} s, expected less than {patience_s:g} s",
            hint="the station abandons a call after that time: see its safety.patience.answer",
        )


def wait_until_arrived(
    device: Approaching, info: DriveInfo, value: float, clock: Clock, poll_s: float
) -> None:
    """Return once a moving drive has arrived; raise DeviceTimeoutError if it is late.

    The time limit follows from its rate, range and settling time.
    """
    until_s = clock.monotonic_s() + info.longest_s
    while not device.arrived(info.name):
        if clock.monotonic_s() >= until_s:
            raise DeviceTimeoutError(
                f"{info.name} reads back {device.read_back(info.name):g} {info.unit} after"
                f" {info.longest_s:g} s, set to {value:g} {info.unit}",
                hint="does it move? see its rate, settling time and tolerance",
            )
        clock.sleep(poll_s)


class Driver:
    """A Readable and Approaching Device; implement `open`, `get` and, with drives, `put`."""

    channels: Sequence[ChannelInfo] = ()
    """Set on the class if all objects have the same, else on the object."""
    drives: Sequence[DriveInfo] = ()
    """The same for drives, in the order in which they are made safe."""
    readings: Sequence[ReadingInfo] = ()
    """Readings that are not numbers; implement `get_reading` for them."""
    non_blocking = False
    poll_s = 0.05
    """Interval of the read-backs of a moving drive."""
    reconnects_after: ClassVar[tuple[type[DeviceError], ...]] = (
        DeviceLostError,
        DeviceTimeoutError,
    )
    """Errors of an exchange after which the connection is reopened before the next call.

    A late answer is then never taken for the answer to another request.
    """
    errors: ClassVar[Mapping[type[Exception], type[DeviceError]]] = {}
    """The DeviceError for each exception of the back end; the first match counts.

    TimeoutError is a DeviceTimeoutError and any other OSError a DeviceLostError by default.
    """

    def __init__(
        self,
        context: DeviceContext,
        channels: Sequence[ChannelInfo] = (),
        drives: Sequence[DriveInfo] = (),
    ) -> None:
        self.clock = context.clock
        _need_several("channels", channels or self.channels)
        _need_several("drives", drives or self.drives)
        self.log = self._device_log = context.log
        self._patience = context.patience
        self._wire = context.wire
        if channels:
            self.channels = tuple(channels)
        if drives:
            self.drives = tuple(drives)
        self._channels = {info.name: info for info in self.channels}
        self._drives = {info.name: info for info in self.drives}
        self._set_points: dict[str, float] = {}
        self._timeout_s: float | None = None
        self._is_open = False
        self._identity: Identity | None = None
        self.is_reconnecting = False
        """Whether `open` is called after a failure: late answers may still arrive."""
        self._lost_by = ""
        """The error after which to reconnect, as text; '' for none."""

    def open(self, timeout_s: float) -> Identity:
        """Open the connection and identify the instrument; raise a DeviceError."""
        raise NotImplementedError

    def shut(self) -> None:
        """Close the connection; also called after `open` failed."""

    def get(self, channel: str) -> float:
        """Return the present value of a channel."""
        raise NotImplementedError

    def get_all(self, channels: Sequence[str]) -> dict[str, float]:
        """Return the present values; for instruments that give several in one exchange."""
        return {name: self._mapped(f"read {name}", partial(self.get, name)) for name in channels}

    def get_reading(self, reading: str) -> Reading:
        """Return the present value of a reading."""
        raise NotImplementedError

    def put(self, drive: str, value: float) -> None:
        """Give a drive a new set-point and return at once."""
        raise NotImplementedError

    def actual(self, drive: str) -> float:
        """Return the actual value of a drive; by default the channel of that name."""
        return self.get(drive)

    def exchange(self, request: str, perform: Callable[[], _T]) -> _T:
        """Do one exchange with the instrument over the wire; see `Wire.exchange`."""
        with self._watched():
            return self._wire.exchange(request, lambda: self._mapped(request, perform))

    def connect(self, timeout_s: float) -> Identity:
        """Open the connection and identify the instrument; close it after a failure."""
        self._timeout_s = timeout_s
        try:
            identity = self._mapped("connect", lambda: self.open(timeout_s))
        except BaseException as error:
            with noted_on(error, "closing the connection"):
                self.close()
            raise
        self._is_open, self._identity, self._lost_by = True, identity, ""
        return identity

    def reconnect(self) -> None:
        """Reopen the connection and check that the same instrument answers.

        Called by itself before the call after a failed exchange; see `reconnects_after`. Raises
        DeviceLostError if no instrument or another one answers. Its time limit leaves room for the
        call that it is part of.
        """
        # Cleared first: a call of the driver within `open` would otherwise reconnect again.
        cause, self._lost_by = self._lost_by or "not connected", ""
        self.is_reconnecting = True
        timeout_s = min(self._timeout_s or _SHORT_S, self._patience.answer_s / 2)
        with suppress(DeviceError):  # of a connection that is broken
            self._mapped("close", self.shut)
        try:
            identity = self._mapped("reconnect", lambda: self.open(timeout_s))
            self._need_same(identity)
        except BaseException as error:
            self._lost_by = cause
            with noted_on(error, "closing the connection"):
                self._mapped("close", self.shut)
            if isinstance(error, DeviceNotFoundError):
                raise DeviceLostError(error.message, hint=error.hint) from error
            raise
        finally:
            self.is_reconnecting = False
        self._is_open, self._lost_by = True, ""
        self._device_log.warning("reconnected to %s after: %s", _named(identity), cause)

    def _need_same(self, identity: Identity) -> None:
        previous = self._identity
        if previous is None or _named(identity) == _named(previous):
            return
        raise DeviceLostError(
            f"reconnected to {_named(identity)}, but the run began with {_named(previous)}",
            hint="was another instrument connected, or its address changed?",
        )

    def close(self) -> None:
        """Close the connection, in any state."""
        self._is_open = False
        self._mapped("close", self.shut)

    def read(self, channels: Sequence[str]) -> dict[str, float]:
        """Return the present value of each channel."""
        self.check_channels(channels)
        with self._watched():
            return self._mapped(f"read {', '.join(channels)}", lambda: self.get_all(channels))

    def observe(self, readings: Sequence[str]) -> dict[str, Reading]:
        """Return the present readings."""
        self._need_connection()
        by_name = {info.name: info for info in self.readings}
        for name in readings:
            _find("reading", name, by_name)
        with self._watched():
            return {
                name: self._mapped(f"read {name}", partial(self.get_reading, name))
                for name in readings
            }

    def check_channels(self, channels: Iterable[str]) -> None:
        """Raise a DeviceError unless connected and all channels exist."""
        self._need_connection()
        for name in channels:
            _find("channel", name, self._channels)

    def begin(self, drive: str, value: float) -> None:
        """Give a drive a new set-point within its limits and return at once."""
        info = _find("drive", drive, self._drives)
        self._need_connection()
        if not info.minimum <= value <= info.maximum:
            raise DeviceRejectedError(
                f"{drive}: {legible(value, info.unit)} is out of range ({info.range_text})"
            )
        with self._watched():
            self._mapped(f"set {drive}", lambda: self.put(drive, value))
        self._set_points[drive] = value

    def arrived(self, drive: str) -> bool:
        """Return whether the read-back is within the tolerance of the last set-point."""
        # A drive that was never set has not arrived: nan compares as False.
        off = abs(self.read_back(drive) - self._set_points.get(drive, float("nan")))
        return off <= self._drives[drive].allowed_deviation

    def set(self, drive: str, value: float) -> None:
        """Give a drive a new set-point and wait until it is reached."""
        self.begin(drive, value)
        wait_until_arrived(self, self._drives[drive], value, self.clock, self.poll_s)

    def read_back(self, drive: str) -> float:
        """Return the actual value of a drive."""
        _find("drive", drive, self._drives)
        self._need_connection()
        with self._watched():
            return self._mapped(f"read back {drive}", lambda: self.actual(drive))

    def make_safe(self) -> Mapping[str, float]:
        """Set all drives to their safe values, one after the other, and read each back.

        A lost connection is reopened once. All drives are set, even if one of them raises; then the
        first error is raised, with the others as its notes.
        """
        read_back: dict[str, float] = {}

        def make_safe(drive: str, value: float) -> None:
            self._set_safe(drive, value)
            read_back[drive] = self.read_back(drive)

        drives = self._drives.items()
        do_all(*(partial(make_safe, drive, info.safe_value) for drive, info in drives))
        return read_back

    def _set_safe(self, drive: str, value: float) -> None:
        self._need_connection_to_make_safe()
        try:
            self.set(drive, value)
        except DeviceError:
            if not self._lost_by:
                raise
            self.set(drive, value)  # over a new connection

    def _need_connection_to_make_safe(self) -> None:
        """Reopen a closed connection; raise DeviceLostError for one that was never opened."""
        if not self._is_open and self._timeout_s is not None:
            self.reconnect()
        self._need_connection()

    def _need_connection(self) -> None:
        """Raise DeviceLostError unless connected; reconnect after a failed exchange."""
        if not self._is_open:
            raise DeviceLostError("not connected")
        if self._lost_by:
            self.reconnect()

    @contextmanager
    def _watched(self) -> Iterator[None]:
        """Remember an error after which to reopen the connection."""
        try:
            yield
        except self.reconnects_after as error:
            self._lost_by = str(error)
            raise

    def _mapped(self, what: str, work: Callable[[], _T]) -> _T:
        try:
            return work()
        except DeviceError:
            raise
        except tuple(self.errors) as error:
            kind = next(ours for theirs, ours in self.errors.items() if isinstance(error, theirs))
            raise kind(f"{what}: {error or type(error).__name__}") from error
        except TimeoutError as error:
            raise DeviceTimeoutError(f"{what}: no answer in time") from error
        except OSError as error:
            raise DeviceLostError(f"{what}: {error.strerror or error}") from error


def _need_several(what: str, infos: Iterable[object]) -> None:
    """Raise PluginError if the value is not a sequence, such as one without its comma."""
    if isinstance(infos, (ChannelInfo, DriveInfo)):
        kind = type(infos).__name__
        raise PluginError(
            f"{what} is one {kind}, expected a tuple of them",
            hint=f"a tuple of one has a comma: `{what} = ({kind}(...),)`",
        )
    needed = ChannelInfo if what == "channels" else DriveInfo
    for info in infos:
        if not isinstance(info, needed):
            raise PluginError(f"{what} has {info!r}, expected a tuple of {needed.__name__}")


def _find(kind: str, name: str, by_name: Mapping[str, _Info]) -> _Info:
    if name not in by_name:
        raise DeviceRejectedError(
            f"there is no {kind} '{name}'", hint=f"there are: {', '.join(by_name) or 'none'}"
        )
    return by_name[name]


def _named(identity: Identity) -> str:
    return " ".join(part for part in (identity.maker, identity.model, identity.serial) if part)
