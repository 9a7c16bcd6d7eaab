"""Settings of an instrument that sends lines; loads without pyserial."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from rigrunner.api import DeviceRejectedError, Frequency, PositiveDuration, SimulableSettings
from rigrunner_plugins.devices.declared import DeclaredChannel, QuantityName, refuse_shared_names
from rigrunner_plugins.devices.text.numbers import NumberInText
from rigrunner_plugins.devices.text.patterns import Identification, Regex, fits, shaped
from rigrunner_plugins.devices.text.readings import ReadingInText
from rigrunner_plugins.devices.text.serial_line import SerialLine
from rigrunner_plugins.devices.text.termination import Termination

if TYPE_CHECKING:
    from rigrunner.api.readings import Reading

PortName = Annotated[str, *shaped(r"/dev/[^\s:]+|COM[0-9]+", "a port such as /dev/ttyUSB0 or COM3")]


class LineChannel(DeclaredChannel, NumberInText):
    """A channel in every line."""


class LineReading(ReadingInText):
    """A reading in every line that is not a number."""


class SerialAsciiSettings(SimulableSettings):
    """An instrument that sends lines, unasked or on request."""

    port: PortName
    """/dev/ttyUSB0, or COM3; on Linux better by its name under /dev/serial/by-id."""
    serial: SerialLine = Field(default_factory=SerialLine)
    """Settings of the serial line."""
    termination: Termination
    """Terminator of a line, such as CRLF, LF, CR or ETX."""
    write_termination: Termination | None = None
    """Terminator of sent lines; if omitted, the same."""
    channels: Annotated[dict[QuantityName, LineChannel], Field(min_length=1)]
    """The channels in every line."""
    readings: dict[QuantityName, LineReading] = Field(default_factory=dict)
    """Further readings in every line that are not numbers: texts, booleans, arrays."""
    example: str = ""
    """Example of a line from the manual; every channel must be readable in it."""
    ignore: Regex = ""
    """Regular expression for whole lines to ignore; if omitted, none."""
    stale: PositiveDuration = 1.0
    """Greatest age of a value; a longer time without a line is an error."""
    rubbish: Annotated[int, Field(ge=1)] = 5
    """Accepted number of consecutive unreadable lines; none while recording."""
    identification: Identification | None = None
    """The expected instrument; if omitted, it is not queried."""
    start: str = ""
    """Sent at the start; if omitted, nothing."""
    stop: str = ""
    """Sent before the port is closed."""
    request: str = ""
    """Sent for each line; if omitted, the instrument sends lines by itself."""
    rate: Annotated[Frequency, Field(gt=0)] | None = None
    """Number of lines per second; if omitted, nothing can be recorded."""

    def physical_addresses(self) -> tuple[str, ...]:
        """Return the port: one run at a time may have it."""
        return (f"serial:{self.port}",)

    @model_validator(mode="after")
    def _belongs_together(self) -> Self:
        refuse_shared_names(self.channels, self.readings)
        if not self.termination:
            raise ValueError("termination is none, but a line needs a terminator")
        if self.request and self.rate is not None:
            raise ValueError(
                "rate is for lines that the instrument sends by itself, not for 'request'"
            )
        if self.simulated and not self.example:
            raise ValueError("simulated: yes needs an example, the line to simulate")
        if self.example:
            try:
                self.values_in(self.example)
                self.readings_in(self.example)
            except DeviceRejectedError as error:
                raise ValueError(f"example: {error.message}") from error
        return self

    def values_in(self, line: str) -> dict[str, float]:
        """Return the value of each channel, in SI; raise DeviceRejectedError."""
        return {
            name: channel.to_si(channel.number_in(line, f"for {name}, a line"))
            for name, channel in self.channels.items()
        }

    def readings_in(self, line: str) -> dict[str, Reading]:
        """Return what is not a number of a line; raise DeviceRejectedError."""
        return {
            name: reading.reading_in(line, f"for {name}, a line")
            for name, reading in self.readings.items()
        }

    def is_ignored(self, line: str) -> bool:
        """Return whether a line is no measurement."""
        return bool(self.ignore) and fits(self.ignore, line)
