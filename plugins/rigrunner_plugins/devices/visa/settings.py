"""Settings of an instrument behind VISA: all that is to be known of it; loads without pyvisa."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api import (
    Duration,
    Frequency,
    ListOf,
    PositiveDuration,
    Settings,
    SimulableSettings,
    YesNo,
)
from rigrunner_plugins.devices.declared import (
    DeclaredChannel,
    DeclaredDrive,
    QuantityName,
    refuse_shared_names,
)
from rigrunner_plugins.devices.text.commands import SettingCommand, as_sent
from rigrunner_plugins.devices.text.numbers import NumberInText
from rigrunner_plugins.devices.text.patterns import (
    Check,
    Command,
    Identification,
    Regex,
    shaped,
)
from rigrunner_plugins.devices.text.readings import ReadingInText
from rigrunner_plugins.devices.text.serial_line import SerialLine
from rigrunner_plugins.devices.text.termination import Termination

_SHARES = [(number + 0.5) / 97 for number in range(97)]
"""Of the range of a drive, at which nobody would round."""
LONGEST_BLOCK_S = 0.5
"""A stop is looked at between blocks."""

ResourceName = Annotated[
    str,
    *shaped(
        r"(TCPIP|ASRL|GPIB|USB|PXI|VXI|PRLGX-)\S*::(INSTR|SOCKET|RAW)",
        "a VISA name such as TCPIP::192.168.0.7::5025::SOCKET, ASRL/dev/ttyUSB0::INSTR"
        " or GPIB0::12::INSTR",
    ),
]
Backend = Annotated[str, *shaped(r"@py|@ivi|([^@]*\.yaml)?@sim", "@py, @ivi or FILE.yaml@sim")]
"""No other: whoever writes a station must not choose which package or library is loaded."""


def check_simulation(backend: str, *, simulated: bool) -> None:
    """Raise ValueError unless the settings say the same: nothing simulated is a measurement."""
    if backend.endswith("@sim") != simulated:
        problem = "is a simulation: write 'simulated: yes'"
        if simulated:
            problem = "talks to an instrument: simulated needs @sim"
        raise ValueError(f"backend {backend} {problem}")


class VisaChannel(DeclaredChannel, NumberInText):
    """A channel and its query."""

    query: Command
    """Query of the present value."""


class VisaReading(ReadingInText):
    """A reading that is not a number, and its query."""

    query: Command
    """Query of the reading."""


class VisaDrive(DeclaredDrive, NumberInText):
    """A drive that is set by a command."""

    command: SettingCommand
    """Command that sets it: 'SOUR:FREQ {value}', or with a format, 'SOUR:FREQ {value:.3f}'."""
    read_back: Command
    """Query of the drive's actual value."""

    @model_validator(mode="after")
    def _is_sent_as_exactly_as_it_is_read_back(self) -> Self:
        info = self.info("")
        values = [info.minimum + share * (info.maximum - info.minimum) for share in _SHARES]
        deviation = max(
            abs(self.to_si(as_sent(self.command, self.from_si(value))) - value) for value in values
        )
        if deviation > info.allowed_deviation:
            raise ValueError(
                f"'{self.command}' rounds a set-point by {deviation:.2g} {info.unit}, more than the"
                f" tolerance of {info.allowed_deviation:.2g} {info.unit}; give it more digits"
            )
        return self


class ErrorQueue(Settings):
    """How the instrument reports errors; queried after every command."""

    query: Command = "SYST:ERR?"
    """Query of the next error."""
    good: Regex = r"[+-]?0(,.*)?"
    """Regular expression for the whole answer without an error."""


class Stream(Settings):
    """How the instrument records channels on one clock and sends them in blocks."""

    rate: Annotated[Frequency, Field(gt=0)]
    """Samples per second and channel, as set in the instrument."""
    channels: Annotated[ListOf[QuantityName], Field(min_length=1)]
    """The channels of each sample, in the order in which they are sent."""
    start: Command
    """The command that starts the acquisition."""
    stop: Command
    """The command that ends it; also sent after an error."""
    fetch: Command
    """The query for the next samples; {samples} is their number."""
    format: Literal["float32", "float64", "int16", "int32", "ascii"]
    """Format of the samples: a block of IEEE 488.2, or a list with commas."""
    byte_order: Literal["little", "big"] | None = None
    """Byte order of the samples in a block: the lowest byte first, or the highest."""
    samples: Annotated[int, Field(ge=1)] = 1000
    """Number of samples per query."""
    overrun: Check | None = None
    """Check after each block, whether the instrument lost samples."""
    paced: YesNo = True
    """Whether samples cannot come faster than `rate`, as from a buffer that was full before."""

    @model_validator(mode="after")
    def _can_be_read(self) -> Self:
        if self.format != "ascii" and self.byte_order is None:
            raise ValueError(f"format {self.format} needs byte_order: little or big")
        if self.samples > self.rate * LONGEST_BLOCK_S:
            raise ValueError(
                f"{self.samples} samples take {self.samples / self.rate:g} s, expected at most"
                f" {LONGEST_BLOCK_S:g} s, since a stop is looked at between blocks"
            )
        if len(set(self.channels)) < len(self.channels):
            raise ValueError("a channel is listed twice")
        return self


class VisaSettings(SimulableSettings):
    """An instrument with text commands, over a socket, a serial line, GPIB or USB."""

    resource: ResourceName
    """Its VISA name, such as TCPIP::192.168.0.7::5025::SOCKET, ASRL/dev/ttyUSB0::INSTR,
    GPIB0::12::INSTR or USB0::0x1AB1::0x0588::DS1K00005888::INSTR."""
    backend: Backend = "@py"
    """@py is pyvisa-py, @ivi the library of a vendor, FILE.yaml@sim a simulation of pyvisa-sim."""
    termination: Termination
    """Terminator of the instrument's messages: LF, CR, CRLF, ...; none if the bus marks the end."""
    write_termination: Termination | None = None
    """Terminator of sent messages; if omitted, the same."""
    timeout: PositiveDuration = 2.0
    """Time limit of an answer."""
    pause: Annotated[Duration, Field(ge=0)] = 0.0
    """Waiting time before each message."""
    serial: SerialLine = Field(default_factory=SerialLine)
    """Settings of a serial line (ASRL) only."""
    identification: Identification | None = None
    """The expected instrument; if omitted, it is not queried."""
    on_connect: ListOf[Command] = ()
    """Commands to send after connecting."""
    verify: ListOf[Check] = ()
    """Checks after that: units, ranges and sample rates that the station needs."""
    acknowledge: Regex = ""
    """Regular expression for its answer to every command; if omitted, it gives none."""
    error_queue: ErrorQueue | None = None
    """Query of errors; if omitted, errors are not queried."""
    channels: dict[QuantityName, VisaChannel] = Field(default_factory=dict)
    """The channels."""
    readings: dict[QuantityName, VisaReading] = Field(default_factory=dict)
    """Readings that are not numbers: texts, booleans, arrays."""
    drives: dict[QuantityName, VisaDrive] = Field(default_factory=dict)
    """The drives, in the order of making safe."""
    safe_commands: ListOf[Command] = ()
    """Commands to send once all drives are safe."""
    stream: Stream | None = None
    """How it records; if omitted, it cannot record."""

    def physical_addresses(self) -> tuple[str, ...]:
        """Return where the instrument is reached: one run at a time may."""
        return (f"visa:{self.resource}",)

    @property
    def has_messages(self) -> bool:
        """Whether the bus itself marks where a message ends: GPIB, USB, VXI-11, HiSLIP."""
        return self.resource.endswith("::INSTR") and not self.resource.startswith("ASRL")

    @model_validator(mode="after")
    def _belongs_together(self) -> Self:
        check_simulation(self.backend, simulated=self.simulated)
        if not self.termination and not self.has_messages:
            raise ValueError(
                f"termination is none, but messages on {self.resource} need a terminator"
            )
        if self.serial != SerialLine() and not self.resource.startswith("ASRL"):
            raise ValueError(f"serial is said, but {self.resource} is not a serial line (ASRL)")
        unknown = [
            name
            for name in (self.stream.channels if self.stream else ())
            if name not in self.channels
        ]
        if unknown:
            raise ValueError(
                f"stream names '{unknown[0]}', which is not among channels:"
                f" {', '.join(self.channels) or 'none'}"
            )
        refuse_shared_names(self.channels, self.readings)
        if not self.channels and not self.drives and not self.readings:
            raise ValueError("it has neither channels nor drives")
        return self
