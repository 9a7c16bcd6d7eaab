"""What a station says of a National Instruments device: its inputs and outputs, and one rate."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api import (
    Angle,
    ChannelInfo,
    Frequency,
    ListOf,
    PositiveDuration,
    Settings,
    Torque,
    YesNo,
)
from rigrunner.api.settings import Voltage, VoltageRatio
from rigrunner_plugins.devices.declared import DeclaredChannel, DeclaredDrive, QuantityName
from rigrunner_plugins.devices.fields import quantity

if TYPE_CHECKING:
    from rigrunner.api import Array

Physical = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]*/[A-Za-z0-9_/]+$")]
"""A physical channel as NI MAX shows it: cDAQ1Mod1/ai0, Dev1/ctr0, Dev1/port0/line0."""


class BridgePoint(Settings):
    """One point of a transducer's characteristic, from its certificate."""

    ratio: VoltageRatio
    """Output of the bridge per volt of excitation."""
    torque: Torque
    """Torque at this output."""


class TorqueChannel(Settings):
    """A torque transducer with a strain gauge bridge."""

    kind: Literal["torque"]
    """Kind of the input or output."""
    source: Physical
    """The analogue input."""
    range: Annotated[Torque, Field(gt=0)]
    """The greatest torque, of either sign, that the input must measure."""
    points: Annotated[ListOf[BridgePoint], Field(min_length=1)]
    """The characteristic: one point in addition to 0 (a sensitivity), two, or a table."""
    bridge: Literal["full", "half", "quarter"] = "full"
    """Number of arms of the bridge with gauges."""
    resistance: Annotated[float, Field(gt=0, strict=False)] = 350.0
    """Resistance of the bridge, in ohm."""
    excitation: Voltage = quantity("2.5 V", "excitation voltage", gt=0)
    excited: Literal["internal", "external"] = "internal"
    """Whether the device supplies the excitation."""
    title: str = ""
    """Name in plots and reports."""

    @property
    def table(self) -> tuple[tuple[float, float], ...]:
        """The characteristic as (mV/V, N·m), by rising ratio; a sensitivity begins at 0."""
        points = [(1e3 * point.ratio, point.torque) for point in self.points]
        return tuple(sorted([(0.0, 0.0), *points] if len(points) == 1 else points))

    def info(self, name: str) -> ChannelInfo:
        """Return the description of the channel."""
        return ChannelInfo(name, "N·m", self.title or name)

    def to_si(self, numbers: Array) -> Array:
        """Return the torque: the device scales it itself."""
        return numbers

    @model_validator(mode="after")
    def _rises(self) -> Self:
        for (left, low), (right, high) in pairwise(self.table):
            if right <= left or (high - low) * (self.table[-1][1] - self.table[0][1]) <= 0:
                raise ValueError("points: torque must always rise, or always fall, with the ratio")
        return self


class VoltageChannel(DeclaredChannel):
    """Any instrument with a voltage output; the number that is scaled is in volts."""

    kind: Literal["voltage"]
    """Kind of the input or output."""
    source: Physical
    """The analogue input."""
    low: Voltage = quantity("-10 V", "the lowest voltage")
    high: Voltage = quantity("10 V", "the highest voltage")
    terminal: Literal["default", "differential", "rse", "nrse", "pseudo_differential"] = "default"
    """Wiring of the input."""

    @model_validator(mode="after")
    def _has_a_range(self) -> Self:
        if self.low >= self.high:
            raise ValueError(f"expected low < high, got {self.low:g} V and {self.high:g} V")
        return self


class EncoderChannel(Settings):
    """An incremental encoder on a counter, read at each edge of the analogue sample clock."""

    kind: Literal["encoder"]
    """Kind of the input or output."""
    source: Physical
    """The counter."""
    pulses: Annotated[int, Field(gt=0)]
    """Pulses per revolution, of one track."""
    decoding: Literal["x1", "x2", "x4"] = "x4"
    """Number of counted edges of a pulse."""
    index: YesNo = False
    """Whether the index pulse resets the angle."""
    index_angle: Angle = 0.0
    """Angle at the index pulse."""
    index_when: Literal["high_high", "high_low", "low_high", "low_low"] = "high_high"
    """Levels of the tracks A and B at which the index pulse counts."""
    start: Angle = 0.0
    """The angle at the start of a recording, which is unknown without an index."""
    scale: Annotated[float, Field(strict=False)] = 1.0
    """Factor of the encoder's angle: -1 reverses it; for a gear, its ratio."""
    title: str = ""
    """Name in plots and reports."""

    def info(self, name: str) -> ChannelInfo:
        """Return the description of the channel."""
        return ChannelInfo(name, "rad", self.title or name)

    def to_si(self, numbers: Array) -> Array:
        """Return the angle for that of the encoder."""
        return numbers * self.scale


Channel = Annotated[TorqueChannel | VoltageChannel | EncoderChannel, Field(discriminator="kind")]


class VoltageOutput(DeclaredDrive):
    """A drive that follows a voltage."""

    kind: Literal["voltage"]
    """Kind of the input or output."""
    source: Physical
    """The analogue output."""
    read_back: QuantityName | None = None
    """The channel of the drive's actual value; if omitted, the value that was written last, which
    is not measured."""


class DigitalOutput(DeclaredDrive):
    """A drive that a line switches: its value is 0 or 1."""

    kind: Literal["digital"]
    """Kind of the input or output."""
    source: Physical
    """The line."""


Output = Annotated[VoltageOutput | DigitalOutput, Field(discriminator="kind")]


class Expected(Settings):
    """The expected device."""

    model: str | None = None
    """Model as shown by NI MAX, such as NI 9237."""
    serial: str | None = None
    """Serial number in hexadecimal digits, as printed on the device."""


class DaqSettings(Settings):
    """A device of National Instruments, all of whose channels share one sample clock."""

    device: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")]
    """Its name in NI MAX, such as Dev1; for modules in a chassis that of the chassis, such as
    cDAQ1."""
    rate: Annotated[Frequency, Field(gt=0)]
    """Samples per second and channel."""
    channels: dict[QuantityName, Channel]
    """The recorded channels."""
    drives: dict[QuantityName, Output] = Field(default_factory=dict)
    """The drives, in the order of making safe."""
    expect: Expected = Field(default_factory=Expected)
    """Expected device; any other is refused."""
    sample_clock: Annotated[str, Field(pattern=r"^/[^\s]+$")] | None = None
    """Terminal of the sample clock for counters; if omitted, that of the analogue inputs, such as
    /Dev1/ai/SampleClock."""
    remove_filter_delay: YesNo = False
    """Whether the device removes the delay of its digital filter from the data, if it can."""
    buffer: PositiveDuration = 10.0
    """Length of the buffer for a delayed computer; a longer delay ends the recording."""

    def physical_addresses(self) -> tuple[str, ...]:
        """Return the device, or the chassis of its modules: one run at a time may reach it."""
        return (f"daq:{self.device}",)

    @property
    def counter_clock(self) -> str:
        """The terminal whose edges counters follow."""
        return self.sample_clock or f"/{self.device}/ai/SampleClock"

    @model_validator(mode="after")
    def _has_a_clock(self) -> Self:
        kinds = {channel.kind for channel in self.channels.values()}
        if not kinds - {"encoder"} and self.sample_clock is None:
            raise ValueError(
                "channels: an encoder follows the sample clock of an analogue input, and there is"
                " none; add one, or name a sample_clock"
            )
        for name, drive in self.drives.items():
            read_back = drive.read_back if isinstance(drive, VoltageOutput) else None
            if read_back is not None and read_back not in self.channels:
                names = ", ".join(self.channels)
                raise ValueError(f"drive {name}: read_back: no channel '{read_back}': {names}")
        return self
