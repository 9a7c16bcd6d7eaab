"""Settings of an instrument that speaks Modbus."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api import Duration, ListOf, PositiveDuration, Settings, SimulableSettings, YesNo
from rigrunner_plugins.devices.declared import (
    DeclaredChannel,
    DeclaredDrive,
    DeclaredQuantity,
    DeclaredReading,
    ExpectedIdentity,
    QuantityName,
    refuse_shared_names,
)
from rigrunner_plugins.devices.modbus.places import Number, Place, Table, Word

_HIGHEST_ON_A_LINE = 247
"""The highest unit address of a serial line (Serial Line V1.02, clause 2.2)."""


class Tcp(Settings):
    """The address of a Modbus TCP unit."""

    host: str
    """Name or address."""
    port: Annotated[int, Field(ge=1, le=65535)] = 502
    """Its TCP port."""


class Rtu(Settings):
    """A serial line; the defaults are those of the standard (Serial Line V1.02, clause 2.5.1)."""

    port: str
    """The serial port, such as /dev/ttyUSB0 or COM3."""
    baud: Annotated[int, Field(ge=300, le=4_000_000)] = 19200
    """Bits per second."""
    parity: Literal["even", "odd", "none"] = "even"
    """The check bit of each character."""
    stop_bits: Annotated[int, Field(ge=1, le=2)] = 1
    """The standard requires 2 without parity."""


class Write(Place):
    """A word that is written into a register, or a 0 or 1 into a coil."""

    value: Word
    """Written value: 1151 or 0x047F, in a coil 0 or 1."""
    wait: Annotated[Duration, Field(ge=0)] = 0.0
    """Waiting time before the next one."""

    @model_validator(mode="after")
    def _can_be_written(self) -> Self:
        _need_writable(self.table)
        if self.table is Table.COIL and self.value > 1:
            raise ValueError(f"value is {self.value}, expected 0 or 1 in a coil")
        return self


class Fault(Number):
    """The fault register of the instrument."""

    ok: Word = 0
    """Value without a fault."""
    codes: dict[str, str] = Field(default_factory=dict)
    """Meaning of each number, from the manual."""


class IdentityPart(Number):
    """The register of a part of the identity: a number or a text."""

    text: Annotated[int, Field(ge=1, le=125)] | None = None
    """Number of registers of a text, of two characters each."""

    @model_validator(mode="after")
    def _is_number_or_text(self) -> Self:
        if self.text is not None and (
            self.table.of_bits or self.type is not None or self.bit is not None
        ):
            raise ValueError("a text is in registers, and has neither type nor bit")
        return self


class Identification(Settings):
    """How the instrument is identified, and the expected identity."""

    standard: YesNo = False
    """Whether it supports Read Device Identification (function 43 / 14)."""
    model: IdentityPart | None = None
    serial: IdentityPart | None = None
    firmware: IdentityPart | None = None
    expect: ExpectedIdentity = Field(default_factory=dict)
    """Expected instrument; a run does not start with another one."""

    @model_validator(mode="after")
    def _asks_for_what_it_expects(self) -> Self:
        readable = {part for part in ("model", "serial", "firmware") if getattr(self, part)}
        readable |= {"maker", "model", "firmware"} if self.standard else set()
        if unread := [part for part in self.expect if part not in readable]:
            raise ValueError(
                f"expect names {', '.join(unread)}, which nothing asks for: give `standard: yes`"
                " or the register"
            )
        return self


class Watchdog(Place):
    """A register that is written or read at regular intervals while connected.

    Many inverters stop if communication stops.
    """

    every: PositiveDuration
    """At most a third of the time after which the instrument stops."""
    write: ListOf[Word] = ()
    """Values that are written in rotation, such as [0, 1]; if omitted, the register is read."""

    @model_validator(mode="after")
    def _can_be_written(self) -> Self:
        if self.write:
            _need_writable(self.table)
        return self


class ModbusChannel(Number, DeclaredChannel):
    """A channel and its register."""


class ModbusReading(Number, DeclaredReading):
    """A reading that is not a number: a boolean in a bit, a text or an array in registers."""

    text: Annotated[int, Field(ge=1, le=125)] | None = None
    """Number of registers of a text, of two characters each."""
    values: Annotated[int, Field(ge=1, le=0x10000)] | None = None
    """Number of consecutive numbers of an array."""
    scale: Annotated[float, Field(strict=False)] = 1.0
    """For an array: factor of each number."""
    offset: Annotated[float, Field(strict=False)] = 0.0
    """For an array: summand, added after scaling."""

    @model_validator(mode="after")
    def _is_array(self) -> Self:
        of_bit = self.table.of_bits or self.bit is not None
        if self.kind == "array" and (self.values is None or of_bit or self.text is not None):
            raise ValueError("an array is in registers: 'values' gives its number of values")
        if self.kind != "array" and {"values", "scale", "offset"} & self.model_fields_set:
            raise ValueError(f"kind is {self.kind}: values, scale and offset are of an array")
        if self.address + self.count * (self.values or 1) - 1 > 0xFFFF:  # noqa: PLR2004  (16 bits)
            raise ValueError(f"{self.values} numbers from {self.address} end beyond 65535")
        return self

    @model_validator(mode="after")
    def _is_bit_or_text(self) -> Self:
        of_bit = self.table.of_bits or self.bit is not None
        if self.kind == "boolean" and (not of_bit or self.text is not None):
            raise ValueError("a boolean is one bit: a coil, a discrete input, or 'bit'")
        if self.kind == "text" and (self.text is None or of_bit or self.type is not None):
            raise ValueError("a text is in registers: 'text' gives their number")
        return self


class ReadBack(Number, DeclaredQuantity):
    """The register of the actual value of a drive."""


class ModbusDrive(Number, DeclaredDrive):
    """A drive and the register of its set-point."""

    read_back: ReadBack | None = None
    """Register of the actual value; if omitted, that of the set-point is read."""
    write: Literal["single", "multiple"] | None = None
    """Function 6 (coils: 5) or 16 (15); if omitted, single for one register."""
    run: ListOf[Write] = ()
    """Written after a set-point, such as the control word that enables the motor."""
    stop: ListOf[Write] = ()
    """Written before the safe value, such as the control word that stops the motor."""

    @model_validator(mode="after")
    def _can_be_driven(self) -> Self:
        _need_writable(self.table)
        if self.bit is not None:
            raise ValueError(
                "a single bit of a register cannot be a drive: use a coil, run or stop"
            )
        if self.write == "single" and self.count > 1:
            raise ValueError(f"write is single, but {self.type} takes {self.count} registers")
        for name in ("min", "max", "safe"):
            try:
                self.encode(self.from_si(getattr(self, name).si))
            except ValueError as error:
                raise ValueError(f"{name} is {getattr(self, name)}: {error}") from error
        return self

    @model_validator(mode="after")
    def _can_be_read_back(self) -> Self:
        back = self.read_back
        if back is not None and back.si_unit != self.si_unit:
            raise ValueError(f"read_back is in {back.unit}, the drive in {self.unit}")
        steps = [_step_si(self), _step_si(back or self)]
        info = self.info("drive")
        if not self.table.of_bits and sum(steps) / 2 > info.allowed_deviation:
            raise ValueError(
                f"the registers have steps of {max(steps):g} {info.unit}, too coarse for the"
                f" tolerance of {info.allowed_deviation:g} {info.unit}"
            )
        return self

    @property
    def multiple(self) -> bool:
        """Whether it is written by the function for several registers or coils."""
        return self.write == "multiple" or self.count > 1


def _step_si(number: ModbusDrive | ReadBack) -> float:
    return abs(number.to_si(number.step) - number.to_si(0.0))


def _need_writable(table: Table) -> None:
    if not table.writable:
        table_name = "an input" if table is Table.INPUT else "a discrete input"
        raise ValueError(f"{table_name} is only read, expected holding or coil")


Simulator = Literal["inverter", "press"]


class ModbusSettings(SimulableSettings):
    """An instrument that speaks Modbus."""

    tcp: Tcp | None = None
    """Address, if it uses Modbus TCP."""
    rtu: Rtu | None = None
    """Serial line, if it uses Modbus RTU."""
    simulator: Simulator | None = None
    """Simulated instrument on loopback, for `simulated: yes`."""
    unit_id: Annotated[int, Field(ge=0, le=255)] = 1
    """Its address on the line or behind the gateway; for a TCP instrument often 1, 255 or 0."""
    timeout: PositiveDuration = 1.0
    """Time limit of an answer."""
    retries: Annotated[int, Field(ge=0, le=10)] = 1
    """Number of repetitions of a request without an answer."""
    group_reads: YesNo = True
    """Whether neighbouring registers are read together."""
    identification: Identification = Field(default_factory=Identification)
    watchdog: Watchdog | None = None
    fault: Fault | None = None
    """Fault register, shown when a drive does not reach its set-point."""
    channels: dict[QuantityName, ModbusChannel] = Field(default_factory=dict)
    """The channels, by name."""
    readings: dict[QuantityName, ModbusReading] = Field(default_factory=dict)
    """Readings that are not numbers: texts, booleans, arrays."""
    drives: dict[QuantityName, ModbusDrive] = Field(default_factory=dict)
    """The drives, in the order of making safe."""

    @model_validator(mode="after")
    def _is_complete(self) -> Self:
        given_keys = [key for key in ("tcp", "rtu", "simulator") if getattr(self, key) is not None]
        if len(given_keys) != 1:
            got = " and ".join(given_keys) or "none"
            raise ValueError(f"expected one of tcp, rtu and simulator, got {got}")
        if self.simulated != (self.simulator is not None):
            raise ValueError(
                "simulator and 'simulated: yes' go together: got one without the other"
            )
        refuse_shared_names(self.channels, self.readings)
        if not self.channels and not self.drives and not self.readings:
            raise ValueError("there are neither channels nor drives, expected at least one")
        if self.rtu is not None and not 1 <= self.unit_id <= _HIGHEST_ON_A_LINE:
            raise ValueError(f"unit_id is {self.unit_id}, expected 1 to 247 on a serial line")
        return self

    def physical_addresses(self) -> tuple[str, ...]:
        """Return the serial line, or the unit at its TCP port: one run at a time may reach it."""
        if self.tcp is not None:
            return (f"tcp:{self.tcp.host}:{self.tcp.port}/unit {self.unit_id}",)
        return () if self.rtu is None else (f"serial:{self.rtu.port}",)

    @property
    def where(self) -> str:
        """The unit in words, such as 'unit 1 at 192.168.1.20:502'."""
        return self.where_is(self.unit_id)

    def where_is(self, unit_id: int) -> str:
        """Return a unit in words."""
        if self.tcp is not None:
            return f"unit {unit_id} at {self.tcp.host}:{self.tcp.port}"
        place = self.simulator if self.rtu is None else self.rtu.port
        return f"unit {unit_id} at {place}"
