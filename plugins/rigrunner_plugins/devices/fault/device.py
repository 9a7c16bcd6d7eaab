"""A device that does what another one does, with faults put in between."""

from __future__ import annotations

import math
import zlib
from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from rigrunner.api import (
    DeviceLostError,
    DeviceRejectedError,
    Pausable,
    PluginError,
    Readable,
    Settable,
    Streaming,
    unit,
)
from rigrunner.api.devices import (
    CountsStreams,
    KnowsStream,
    KnowsTruth,
    Observing,
    ReadableInPlaces,
)
from rigrunner.api.samples import as_samples
from rigrunner.api.units import with_article
from rigrunner_plugins.devices.channels import info_of
from rigrunner_plugins.devices.fault.answers import HINT, affect
from rigrunner_plugins.devices.fault.blocks import extra_s, spoilt_blocks
from rigrunner_plugins.devices.fault.samples import KINDS, Stream, spoil_for
from rigrunner_plugins.devices.fault.settings import CHANNELS_UNIT, NATURES

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from rigrunner.api import (
        Block,
        ChannelInfo,
        Device,
        DeviceContext,
        DriveInfo,
        Identity,
        StopToken,
    )
    from rigrunner.api.devices import ReadingInfo
    from rigrunner.api.readings import Reading
    from rigrunner_plugins.devices.fault.samples import Spoil
    from rigrunner_plugins.devices.fault.settings import Call, FaultSettings, FaultyDeviceSettings


def check_faults(faults: Iterable[FaultSettings], device: Device) -> None:
    """Raise PluginError for a channel or drive that is not there, or a quantity of another kind."""
    for number, fault in enumerate(faults, start=1):
        where = f"fault {number} ({fault.kind})"
        no_drive = f"{where}: the device has no drive"
        if fault.drive:
            info_of(device.drives, fault.drive, no_drive)
        for name, value in fault.at.items():
            _check_unit(where, "at", value.dimension, info_of(device.drives, name, no_drive))
        if fault.kind == "wrong frequency" and not any(
            drive.sets_cycle_frequency for drive in device.drives
        ):
            raise PluginError(f"{where}: the device has no drive that sets a frequency")
        if fault.call == "stream":
            channel = info_of(device.channels, fault.channel, f"{where}: the device has no channel")
            if NATURES[fault.kind].dimension == CHANNELS_UNIT and fault.extent is not None:
                _check_unit(where, "extent", fault.extent.dimension, channel)


def _check_unit(where: str, field: str, got: str, info: ChannelInfo | DriveInfo) -> None:
    expected = unit(info.unit).dimension
    if got != expected:
        raise PluginError(
            f"{where}: {field}: got {with_article(got)}, {info.name} takes {with_article(expected)}"
        )


class Occasions:
    """Counts the calls that a fault may affect, since the device was connected.

    What is left to chance follows from the seed, the call, the set-points and how often the call
    was made there: the order in which set-points come does not matter.
    """

    def __init__(self, faults: Sequence[FaultSettings], seed: int) -> None:
        self._faults = tuple(faults)
        self._seed = seed
        self._calls: Counter[int] = Counter()
        self._at_place: Counter[tuple[int, str]] = Counter()

    def begin(self) -> None:
        """Count again."""
        self._calls.clear()
        self._at_place.clear()

    def due(
        self, call: Call, set_points: Mapping[str, float], drive: str = ""
    ) -> Iterator[tuple[FaultSettings, np.random.Generator]]:
        """Yield the faults that affect this call, each with its source of random numbers."""
        place = f"{call} {drive} " + " ".join(f"{k}={v:.6g}" for k, v in set_points.items())
        for index, fault in enumerate(self._faults):
            if fault.call != call or fault.drive not in ("", drive):
                continue
            if not all(
                math.isclose(set_points[name], quantity.si, rel_tol=1e-6)
                for name, quantity in fault.at.items()
            ):
                continue
            self._calls[index] += 1
            self._at_place[index, place] += 1
            words = zlib.crc32(place.encode())
            rng = np.random.default_rng([self._seed, index, words, self._at_place[index, place]])
            chance = rng.uniform()
            chosen = not fault.calls or self._calls[index] in fault.calls
            if chosen and chance < fault.probability:
                yield fault, rng


def make(settings: FaultyDeviceSettings, context: DeviceContext) -> Device:
    """Return the wrapped device with its faults: it has the abilities of that one, and no others.

    Raises PluginError where that one cannot be made, or a fault does not fit it.
    """
    inner = context.make(settings.plugin, settings.settings)
    check_faults(settings.faults, inner)
    abilities = [mixin for ability, mixin in _PARTS.items() if isinstance(inner, ability)]
    kind = type("FaultyDevice", (*abilities, FaultyDevice), {})
    return cast("Device", kind(settings, context, inner))


class FaultyDevice:
    """What every device can do, with faults."""

    def __init__(
        self, settings: FaultyDeviceSettings, context: DeviceContext, inner: Device
    ) -> None:
        self._inner: Any = inner
        self._clock = context.clock
        self._faults = settings.faults
        self._occasions = Occasions(settings.faults, settings.seed)
        self._lost = False
        self._connected_s = 0.0
        self._scales: dict[str, float] = {}
        self._set_points = self._safe_points()

    @property
    def channels(self) -> Sequence[ChannelInfo]:
        """The channels of the wrapped device."""
        return cast("Sequence[ChannelInfo]", self._inner.channels)

    @property
    def drives(self) -> Sequence[DriveInfo]:
        """The drives of the wrapped device."""
        return cast("Sequence[DriveInfo]", self._inner.drives)

    @property
    def non_blocking(self) -> bool:
        """False where a fault makes it wait, so that it is not waited for without end."""
        waits = any(fault.kind in ("late", "timeout") for fault in self._faults)
        return bool(self._inner.non_blocking) and not waits

    @property
    def reads_back_while_streaming(self) -> bool:
        """Whether the wrapped device does."""
        return bool(getattr(self._inner, "reads_back_while_streaming", False))

    def connect(self, timeout_s: float) -> Identity:
        """Connect; what was lost is there again, and calls are counted again.

        With faults it says that it is simulated: what it measures is no measurement to certify.
        """
        self._lost = False
        self._occasions.begin()
        self._connected_s = self._clock.monotonic_s()
        self._apply("connect")
        identity = cast("Identity", self._inner.connect(timeout_s))
        if not self._faults:
            return identity
        return replace(identity, model=f"{identity.model} with faults put in", simulated=True)

    def make_safe(self) -> Mapping[str, float]:
        """Make the wrapped device safe, unless a fault is in the way."""
        self._apply("make safe")
        self._scales.clear()
        self._set_points = self._safe_points()
        return cast("Mapping[str, float]", self._inner.make_safe())

    def close(self) -> None:
        """Release the connection."""
        self._inner.close()

    def _safe_points(self) -> dict[str, float]:
        return {info.name: info.safe_value for info in self._inner.drives}

    def _apply(self, call: Call, drive: str = "") -> list[FaultSettings]:
        """Apply the faults that are due to a call that is no stream; return them."""
        self._need_connection(call)
        due = [fault for fault, _ in self._occasions.due(call, self._set_points, drive)]
        for fault in due:
            self._lost |= fault.kind == "lost"
            affect(fault, call, self._clock)
        return due

    def _need_connection(self, call: str) -> None:
        if self._lost:
            raise DeviceLostError(f"cannot {call}: the connection is lost", hint=HINT)


class _FaultyReadable(FaultyDevice):
    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        """Return the present value of each channel."""
        due = self._apply("read")
        values = dict(self._inner.read(channels))
        for fault in due:
            if fault.kind == "nan" and fault.channel in values:
                values[fault.channel] = math.nan
        return values


class _FaultySettable(FaultyDevice):
    def set(self, drive: str, value: float) -> None:
        """Give the drive a new set-point, unless it is stuck or takes it for another one."""
        due = {fault.kind: fault for fault in self._apply("set", drive)}
        if "stuck" in due:
            return
        applied = value
        info = next((candidate for candidate in self.drives if candidate.name == drive), None)
        if "wrong frequency" in due and info is not None and info.sets_cycle_frequency:
            wrong = value * (1 + due["wrong frequency"].extent_si)
            applied = min(max(wrong, info.minimum), info.maximum)
        self._inner.set(drive, applied)
        # The drive believes that it is where it was set: only the recording shows the wrong
        # frequency.
        self._scales[drive] = applied / value if value else 1.0
        self._set_points[drive] = value

    def read_back(self, drive: str) -> float:
        """Return the drive's value as it believes it to be."""
        due = self._apply("read back", drive)
        actual = float(self._inner.read_back(drive)) / self._scales.get(drive, 1.0)
        return math.nan if any(fault.kind == "nan" for fault in due) else actual


class _FaultyStreaming(FaultyDevice):
    @property
    def sample_rate_hz(self) -> float:
        """Samples per second and channel."""
        return float(self._inner.sample_rate_hz)

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        """Yield the blocks of the wrapped device with the faults that are due."""
        self._need_connection("stream")
        due = [
            (fault, rng)
            for fault, rng in self._occasions.due("stream", self._set_points)
            if fault.channel in channels or fault.kind not in KINDS
        ]
        longer_s = duration_s + sum(extra_s(fault) for fault, _ in due)
        blocks = self._inner.stream(channels, longer_s, stop)
        return self._spoilt(blocks, due, round(duration_s * self.sample_rate_hz))

    def _spoilt(
        self,
        blocks: Iterator[Block],
        due: Sequence[tuple[FaultSettings, np.random.Generator]],
        samples: int,
    ) -> Iterator[Block]:
        since_s = self._clock.monotonic_s() - self._connected_s
        stream = Stream(samples, self.sample_rate_hz, since_s)
        for fault, rng in due:
            spoil = spoil_for(fault, stream, rng)
            if spoil is None:
                blocks = spoilt_blocks(fault, blocks, samples, rng, self._clock)
            else:
                blocks = _with_samples(blocks, fault.channel, spoil)
        try:
            yield from blocks
        except DeviceLostError:
            self._lost = True
            raise


class _FaultyKnowsStream(_FaultyStreaming):
    def stream_conditions(self) -> Mapping[str, tuple[float, str]]:
        """Return what the wrapped device reports of its last stream."""
        return cast("Mapping[str, tuple[float, str]]", self._inner.stream_conditions())


class _FaultyPausable(FaultyDevice):
    def pause(self) -> None:
        """Let the wrapped device stand still."""
        self._need_connection("pause")
        self._inner.pause()

    def resume(self) -> None:
        """Let it go on."""
        self._need_connection("resume")
        self._inner.resume()


class _FaultyCountsStreams(FaultyDevice):
    def continue_after(self, streams: Sequence[Mapping[str, float]]) -> None:
        """Pass the earlier streams to the wrapped device."""
        self._inner.continue_after(streams)


class _FaultyObserving(FaultyDevice):
    @property
    def readings(self) -> Sequence[ReadingInfo]:
        """The readings of the wrapped device."""
        return cast("Sequence[ReadingInfo]", self._inner.readings)

    def observe(self, readings: Sequence[str]) -> Mapping[str, Reading]:
        """Return the readings of the wrapped device; the faults are of numbers."""
        self._need_connection("observe")
        return cast("Mapping[str, Reading]", self._inner.observe(readings))


class _FaultyReadableInPlaces(_FaultyReadable):
    def unreadable_at(self, set_points: Mapping[str, float]) -> DeviceRejectedError | None:
        """Return why the wrapped device cannot be read at these set-points; None if it can."""
        return cast("DeviceRejectedError | None", self._inner.unreadable_at(set_points))


class _FaultyKnowsTruth(FaultyDevice):
    def truth(self) -> Mapping[str, float]:
        """Return what the wrapped simulator knows: of the rig, whatever the faults make of it."""
        return cast("Mapping[str, float]", self._inner.truth())


# A class comes before that which is its base: Python takes no other order of bases.
_PARTS: dict[type, type[FaultyDevice]] = {
    ReadableInPlaces: _FaultyReadableInPlaces,
    Readable: _FaultyReadable,
    Settable: _FaultySettable,
    KnowsStream: _FaultyKnowsStream,
    Streaming: _FaultyStreaming,
    Pausable: _FaultyPausable,
    CountsStreams: _FaultyCountsStreams,
    KnowsTruth: _FaultyKnowsTruth,
    Observing: _FaultyObserving,
}


def _with_samples(blocks: Iterator[Block], channel: str, spoil: Spoil) -> Iterator[Block]:
    for block in blocks:
        try:
            values = as_samples(block.channels[channel])
        except TypeError as error:
            message = f"{channel}: the samples are {error}, expected real numbers"
            raise DeviceRejectedError(message) from error
        spoilt = spoil(block.first_sample, values)
        yield replace(block, channels={**block.channels, channel: spoilt})
