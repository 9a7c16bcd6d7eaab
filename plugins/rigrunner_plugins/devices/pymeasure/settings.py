"""Settings of an instrument that PyMeasure drives; loads without pymeasure."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import AfterValidator, Field, WithJsonSchema, model_validator

from rigrunner.api import ListOf, PositiveDuration, SimulableSettings, YesNo
from rigrunner_plugins.devices.declared import DeclaredChannel, DeclaredDrive, QuantityName
from rigrunner_plugins.devices.text.patterns import Regex, shaped
from rigrunner_plugins.devices.visa.settings import Backend, ResourceName, check_simulation

FAKES = "pymeasure.instruments.fakes."

ClassName = Annotated[
    str,
    *shaped(
        r"pymeasure\.instruments(\.[A-Za-z]\w*){2,}",
        "a class of PyMeasure such as pymeasure.instruments.keithley.Keithley2000",
    ),
]
"""Of PyMeasure's own package alone: whoever writes a station must not choose what is loaded."""
PropertyName = Annotated[
    str, *shaped(r"[A-Za-z]\w*(\.[A-Za-z]\w*)?", "a property such as voltage or ch_1.voltage")
]
"""Of the instrument, or of one of its channels: ch_1.voltage."""
MethodName = Annotated[str, *shaped(r"[A-Za-z]\w*", "a name such as shutdown")]


def _plain(value: object) -> object:
    if isinstance(value, (bool, int, float, str)):
        return value
    raise ValueError("expected a number, a text, true or false")


Plain = Annotated[
    Any, AfterValidator(_plain), WithJsonSchema({"type": ["boolean", "number", "string"]})
]


class PropertyChannel(DeclaredChannel):
    """A channel that a property gives."""

    property: PropertyName
    """The property that is read."""
    item: Annotated[int, Field(ge=1)] | None = None
    """Which number, from 1, if the property gives several."""


class PropertyDrive(DeclaredDrive):
    """A drive that a property sets."""

    property: PropertyName
    """The property that is set, and read back."""
    read_back: PropertyName | None = None
    """The property of the drive's actual value; if omitted, the same."""


class PyMeasureSettings(SimulableSettings):
    """A PyMeasure class, the address of its instrument, and the properties to use."""

    instrument: ClassName
    """The class, such as pymeasure.instruments.keithley.Keithley2000."""
    resource: ResourceName
    """The VISA name of the instrument, such as GPIB0::16::INSTR."""
    backend: Backend = "@py"
    """@py is pyvisa-py, @ivi the library of a vendor, FILE.yaml@sim a simulation of pyvisa-sim."""
    timeout: PositiveDuration = 2.0
    """Time limit of an answer."""
    connection: dict[MethodName, Plain] = Field(default_factory=dict)
    """Further settings of the connection, such as {baud_rate: 9600}."""
    expect: Regex = ""
    """Regular expression for the whole answer to *IDN?; if omitted, it is not queried."""
    setup: dict[PropertyName, Plain] = Field(default_factory=dict)
    """Properties to set after connecting."""
    calls: ListOf[MethodName] = ()
    """Methods to call after that, without arguments."""
    safe_calls: ListOf[MethodName] = ()
    """Methods to call once all drives are safe, such as shutdown."""
    check_errors: YesNo = False
    """Whether the instrument's errors are checked after each setting."""
    channels: dict[QuantityName, PropertyChannel] = Field(default_factory=dict)
    """The channels."""
    drives: dict[QuantityName, PropertyDrive] = Field(default_factory=dict)
    """The drives, in the order of making safe."""

    def physical_addresses(self) -> tuple[str, ...]:
        """Return where the instrument is reached: one run at a time may."""
        return (f"visa:{self.resource}",)

    @property
    def properties(self) -> set[str]:
        """The names of all properties that are used."""
        read = {channel.property for channel in self.channels.values()}
        set_ = {drive.property for drive in self.drives.values()}
        back = {drive.read_back for drive in self.drives.values() if drive.read_back}
        return read | set_ | back | set(self.setup)

    @model_validator(mode="after")
    def _belongs_together(self) -> Self:
        if self.instrument.startswith(FAKES):
            if not self.simulated:
                raise ValueError(f"{self.instrument} is a simulation: write 'simulated: yes'")
        else:
            check_simulation(self.backend, simulated=self.simulated)
        if not self.channels and not self.drives:
            raise ValueError("it has neither channels nor drives")
        return self
