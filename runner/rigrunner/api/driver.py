"""What is the same in every driver: limits, settling, safe state, errors.

A driver of your own derives from `Driver` and says how to `open`, `shut`, `get` and `put`; all
values are in the unit of the ChannelInfo or DriveInfo, the coherent SI unit.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, ClassVar, TypeVar

from rigrunner.api.errors import (
    DeviceError,
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
    PluginError,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from rigrunner.api.devices import (
        Approaching,
        ChannelInfo,
        Clock,
        DeviceContext,
        DriveInfo,
        Identity,
    )

_T = TypeVar("_T")
_Info = TypeVar("_Info")


def check_patience(timeout_s: float, context: DeviceContext) -> None:
    """Raise PluginError unless an answer is given up before the station gives the device up.

    A device that was given up takes no further call, and cannot be made safe in order.
    """
    patience_s = context.patience.answer_s
    if timeout_s >= patience_s:
        raise PluginError(
            f"timeout: got {timeout_s:g} s, allowed is less than {patience_s:g} s",
            hint="after that the station gives a device up: see its safety.patience.answer",
        )


def wait_until_arrived(
    device: Approaching, info: DriveInfo, value: float, clock: Clock, poll_s: float
) -> None:
    """Return once a drive that has begun to move is there; raise DeviceTimeoutError if it is late.

    It may take the longest time that its rate, range and settling time allow.
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
    """A Device that is Readable and Approaching; give it `open`, `get` and, with drives, `put`."""

    channels: Sequence[ChannelInfo] = ()
    """Of the class where they are always the same, else given to each object."""
    drives: Sequence[DriveInfo] = ()
    """The same, in the order in which they are made safe."""
    non_blocking = False
    poll_s = 0.05
    """How often a drive that is on its way is read back."""
    errors: ClassVar[Mapping[type[Exception], type[DeviceError]]] = {}
    """Which DeviceError stands for what the back end raises, the first that fits.

    A TimeoutError is a DeviceTimeoutError and any other OSError a DeviceLostError by themselves.
    """

    def __init__(
        self,
        context: DeviceContext,
        channels: Sequence[ChannelInfo] = (),
        drives: Sequence[DriveInfo] = (),
    ) -> None:
        self.clock = context.clock
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

    def open(self, timeout_s: float) -> Identity:
        """Open the connection and say who answers; raise a DeviceError."""
        raise NotImplementedError

    def shut(self) -> None:
        """Give the connection back; also called after `open` failed."""

    def get(self, channel: str) -> float:
        """Return the present value of a channel."""
        raise NotImplementedError

    def get_all(self, channels: Sequence[str]) -> dict[str, float]:
        """Return the present values; for instruments that give several in one exchange."""
        return {name: self._mapped(f"read {name}", partial(self.get, name)) for name in channels}

    def put(self, drive: str, value: float) -> None:
        """Give a drive a new set-point and return at once."""
        raise NotImplementedError

    def actual(self, drive: str) -> float:
        """Return where a drive stands; by itself the channel of that name."""
        return self.get(drive)

    def exchange(self, request: str, perform: Callable[[], _T]) -> _T:
        """Do one exchange with the instrument over the wire; see `Wire.exchange`."""
        return self._wire.exchange(request, lambda: self._mapped(request, perform))

    def connect(self, timeout_s: float) -> Identity:
        """Open the connection and say who answers; after a failure it is shut again."""
        self._timeout_s = timeout_s
        try:
            identity = self._mapped("connect", lambda: self.open(timeout_s))
        except BaseException:
            self.close()
            raise
        self._is_open = True
        return identity

    def close(self) -> None:
        """Give the connection back, in any state."""
        self._is_open = False
        self._mapped("close", self.shut)

    def read(self, channels: Sequence[str]) -> dict[str, float]:
        """Return the present value of each channel."""
        self.check_channels(channels)
        return self._mapped(f"read {', '.join(channels)}", lambda: self.get_all(channels))

    def check_channels(self, channels: Iterable[str]) -> None:
        """Raise a DeviceError unless it is connected and has all of these channels."""
        self._need_connection()
        for name in channels:
            _find("channel", name, self._channels)

    def begin(self, drive: str, value: float) -> None:
        """Give a drive a new set-point within its limits and return at once."""
        info = _find("drive", drive, self._drives)
        self._need_connection()
        if not info.minimum <= value <= info.maximum:
            raise DeviceRejectedError(
                f"{drive} cannot be set to {value:g} {info.unit}",
                hint=f"allowed: {info.minimum:g} to {info.maximum:g} {info.unit}",
            )
        self._mapped(f"set {drive}", lambda: self.put(drive, value))
        self._set_points[drive] = value

    def arrived(self, drive: str) -> bool:
        """Say whether the read-back is within the tolerance of the last set-point."""
        off = abs(self.read_back(drive) - self._set_points.get(drive, float("nan")))
        return off <= self._drives[drive].allowed_deviation

    def set(self, drive: str, value: float) -> None:
        """Give a drive a new set-point and wait until it is reached."""
        self.begin(drive, value)
        wait_until_arrived(self, self._drives[drive], value, self.clock, self.poll_s)

    def read_back(self, drive: str) -> float:
        """Return where a drive stands."""
        _find("drive", drive, self._drives)
        self._need_connection()
        return self._mapped(f"read back {drive}", lambda: self.actual(drive))

    def make_safe(self) -> Mapping[str, float]:
        """Bring all drives to their safe values, one after the other, and read each back.

        A connection that is lost is opened once more. All drives are tried; then the first error is
        raised.
        """
        read_back: dict[str, float] = {}
        failed: list[DeviceError] = []
        for drive, info in self._drives.items():
            try:
                self._set_safe(drive, info.safe_value)
                read_back[drive] = self.read_back(drive)
            except DeviceError as error:
                failed.append(error)
        if failed:
            for other in failed[1:]:
                failed[0].add_note(str(other))
            raise failed[0]
        return read_back

    def _set_safe(self, drive: str, value: float) -> None:
        try:
            self.set(drive, value)
        except DeviceLostError:
            if self._timeout_s is None:  # it was never connected: nothing of it is known
                raise
            self.close()
            self.connect(self._timeout_s)
            self.set(drive, value)

    def _need_connection(self) -> None:
        if not self._is_open:
            raise DeviceLostError("not connected")

    def _mapped(self, what: str, work: Callable[[], _T]) -> _T:
        try:
            return work()
        except DeviceError:
            raise
        except tuple(self.errors) as error:
            kind = next(mine for theirs, mine in self.errors.items() if isinstance(error, theirs))
            raise kind(f"{what}: {error or type(error).__name__}") from error
        except TimeoutError as error:
            raise DeviceTimeoutError(f"{what}: no answer in time") from error
        except OSError as error:
            raise DeviceLostError(f"{what}: {error.strerror or error}") from error


def _find(kind: str, name: str, known: Mapping[str, _Info]) -> _Info:
    if name not in known:
        raise DeviceRejectedError(
            f"there is no {kind} '{name}'", hint=f"there are: {_listing(known)}"
        )
    return known[name]


def _listing(names: Iterable[str]) -> str:
    return ", ".join(names) or "none"
