"""A device with the tape at its calls, for devices whose exchanges do not go over a wire."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, cast

from rigrunner.api.data import Block
from rigrunner.api.devices import (
    Approaching,
    CountsStreams,
    Identity,
    KnowsStream,
    KnowsTruth,
    Observing,
    Pausable,
    Readable,
    ReadableInPlaces,
    Settable,
    Streaming,
)
from rigrunner.api.errors import DeviceRejectedError
from rigrunner.rig.drives import as_number
from rigrunner.tape.stop import plain_stop

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from rigrunner.api.devices import ChannelInfo, Device, DriveInfo, ReadingInfo, StopToken, Wire
    from rigrunner.api.readings import Reading


def taped(
    inner: Device, wire: Wire, stop_for: Callable[[StopToken], StopToken] = plain_stop
) -> Device:
    """Return a device with the same abilities, whose calls go over the wire.

    `stop_for` makes the stop token of its streams from the given one. Attributes available before
    connecting are not recorded.
    """
    parts = [part for ability, part in _PARTS.items() if isinstance(inner, ability)]
    # A class for these abilities alone: `isinstance` of a Protocol looks at the attributes.
    kind = type("TapedDevice", (*parts, TapedDevice), {})
    return cast("Device", kind(inner, wire, stop_for))


class TapedDevice:
    """The common part of all devices."""

    def __init__(
        self, inner: Device, wire: Wire, stop_for: Callable[[StopToken], StopToken]
    ) -> None:
        self._inner: Any = inner
        self._wire = wire
        self._stop_for = stop_for

    @property
    def channels(self) -> Sequence[ChannelInfo]:
        """The channels of the device."""
        return cast("Sequence[ChannelInfo]", self._inner.channels)

    @property
    def drives(self) -> Sequence[DriveInfo]:
        """The drives of the device."""
        return cast("Sequence[DriveInfo]", self._inner.drives)

    @property
    def non_blocking(self) -> bool:
        """Whether no call can hang."""
        return bool(self._inner.non_blocking)

    @property
    def reads_back_while_streaming(self) -> bool:
        """Whether its drives can be read back while it streams."""
        return bool(getattr(self._inner, "reads_back_while_streaming", False))

    def connect(self, timeout_s: float) -> Identity:
        """Connect; return the identity."""
        return _identity(
            self._wire.exchange("connect", lambda: asdict(self._inner.connect(timeout_s)))
        )

    def make_safe(self) -> Mapping[str, float]:
        """Set every drive to its safe value."""
        return self._wire.exchange("make safe", lambda: _mapping(self._inner.make_safe()))

    def close(self) -> None:
        """Close the connection."""
        self._wire.exchange("close", self._inner.close)


class _Readable(TapedDevice):
    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        """Return the present value of each channel."""
        return self._wire.exchange(
            f"read {_listing(channels)}", lambda: _mapping(self._inner.read(channels))
        )


class _ReadableInPlaces(_Readable):
    def unreadable_at(self, set_points: Mapping[str, float]) -> DeviceRejectedError | None:
        """Ask the device itself: this is asked of a plan, before there is a tape."""
        return cast("DeviceRejectedError | None", self._inner.unreadable_at(set_points))


class _Observing(TapedDevice):
    @property
    def readings(self) -> Sequence[ReadingInfo]:
        """The readings that are not numbers."""
        return cast("Sequence[ReadingInfo]", self._inner.readings)

    def observe(self, readings: Sequence[str]) -> Mapping[str, Reading]:
        """Return the present readings."""
        # JSON has no tuples: an array goes as a list, and comes back as one.
        observed = self._wire.exchange(
            f"observe {_listing(readings)}",
            lambda: {
                name: list(value) if isinstance(value, tuple) else value
                for name, value in _mapping(self._inner.observe(readings)).items()
            },
        )
        return {n: tuple(v) if isinstance(v, list) else v for n, v in observed.items()}


class _Settable(TapedDevice):
    def set(self, drive: str, value: float) -> None:
        """Give the drive a new set-point."""
        self._wire.exchange(f"set {drive} {value!r}", lambda: self._inner.set(drive, value))

    def read_back(self, drive: str) -> float:
        """Return the actual value of the drive."""
        return self._wire.exchange(
            f"read back {drive}", lambda: as_number(self._inner.read_back(drive))
        )


class _Approaching(_Settable):
    def begin(self, drive: str, value: float) -> None:
        """Give the drive a new set-point and return at once."""
        self._wire.exchange(f"begin {drive} {value!r}", lambda: self._inner.begin(drive, value))

    def arrived(self, drive: str) -> bool:
        """Return whether the drive has reached its set-point."""
        return self._wire.exchange(f"arrived {drive}", lambda: bool(self._inner.arrived(drive)))


class _Streaming(TapedDevice):
    @property
    def sample_rate_hz(self) -> float:
        """Samples per second and channel."""
        return float(self._inner.sample_rate_hz)

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        """Yield the blocks of the device."""
        # Stays empty in a replay, which performs nothing: the blocks are on the tape.
        source: list[Iterator[Block]] = []
        token = self._stop_for(stop)
        self._wire.exchange(
            f"stream {_listing(channels)} for {duration_s!r} s",
            lambda: source.append(iter(self._inner.stream(channels, duration_s, token))),
        )
        return self._blocks(source)

    def _blocks(self, source: list[Iterator[Block]]) -> Iterator[Block]:
        try:
            while (block := self._wire.exchange("next block", lambda: _next(source))) is not None:
                yield Block(**block)
        finally:
            # Not on the tape: when a dropped stream is ended is not known.
            for blocks in source:
                if (close := getattr(blocks, "close", None)) is not None:
                    close()


class _KnowsStream(_Streaming):
    def stream_conditions(self) -> Mapping[str, tuple[float, str]]:
        """Return the values measured of its last stream."""
        conditions = self._wire.exchange(
            "tell of the stream",
            lambda: _conditions(self._inner.stream_conditions()),
        )
        return {name: (value, unit) for name, (value, unit) in conditions.items()}


class _Pausable(TapedDevice):
    def pause(self) -> None:
        """Pause the motion."""
        self._wire.exchange("pause", self._inner.pause)

    def resume(self) -> None:
        """Resume the motion."""
        self._wire.exchange("resume", self._inner.resume)


class _CountsStreams(TapedDevice):
    def continue_after(self, streams: Sequence[Mapping[str, float]]) -> None:
        """Continue after earlier streams."""
        self._wire.exchange(
            f"continue after {len(streams)} streams", lambda: self._inner.continue_after(streams)
        )


class _KnowsTruth(TapedDevice):
    def truth(self) -> Mapping[str, float]:
        """Return the true values of the last stream."""
        return self._wire.exchange("tell the truth", lambda: dict(self._inner.truth()))


def _mapping(answer: object) -> dict[str, Any]:
    """Return a mapping of a driver as a plain one; raise DeviceRejectedError for another answer."""
    if isinstance(answer, Mapping):
        return dict(answer)
    raise DeviceRejectedError(f"the driver gave {answer!r:.80}, which is not a mapping")


def _conditions(answer: object) -> dict[str, tuple[float, str]]:
    pairs = _mapping(answer).items()
    try:
        return {name: (as_number(value), str(unit)) for name, (value, unit) in pairs}
    except (TypeError, ValueError) as error:
        raise DeviceRejectedError(f"the driver gave {answer!r:.80} as conditions") from error


_PARTS: dict[type, type[TapedDevice]] = {
    ReadableInPlaces: _ReadableInPlaces,  # before Readable, which it includes
    Readable: _Readable,
    Observing: _Observing,
    Approaching: _Approaching,  # before Settable, which it includes
    Settable: _Settable,
    KnowsStream: _KnowsStream,  # before Streaming, which it includes
    Streaming: _Streaming,
    Pausable: _Pausable,
    CountsStreams: _CountsStreams,
    KnowsTruth: _KnowsTruth,
}


def _listing(channels: Sequence[str]) -> str:
    return ", ".join(channels)


def _identity(stored: Mapping[str, Any]) -> Identity:
    parts = {name: _identity(part) for name, part in stored["parts"].items()}
    return Identity(**{**stored, "parts": parts})


def _next(source: list[Iterator[Block]]) -> dict[str, Any] | None:
    block = next(source[0], None)
    if block is None:
        return None
    return {
        "rate_hz": block.rate_hz,
        "first_sample": block.first_sample,
        "monotonic_s": block.monotonic_s,
        "channels": dict(block.channels),
    }
