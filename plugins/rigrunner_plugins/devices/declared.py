"""Channels and drives that a station declares, for instruments that a protocol alone describes.

A subclass of these settings adds where the quantity is found: a command, a register, a node.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, Self, TypeAlias, TypeVar

from pydantic import Field, StringConstraints, model_validator

from rigrunner.api import (
    AnyQuantity,
    ChannelInfo,
    DeviceNotFoundError,
    DriveInfo,
    Duration,
    Settings,
    UnitSymbol,
    YesNo,
    unit,
)
from rigrunner.api.devices import ReadingInfo
from rigrunner.api.readings import ReadingKind
from rigrunner.api.settings import Difference
from rigrunner.api.units import si_symbol, with_article

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api import Array, Quantity

_Number = TypeVar("_Number", float, "Array")


QuantityName = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*$")]
"""Of a channel or a drive."""
ExpectedIdentity: TypeAlias = dict[Literal["maker", "model", "serial", "firmware"], str]
"""Parts of the identity with what they must be."""


class DeclaredQuantity(Settings):
    """How the instrument's numbers become a quantity: number * scale + offset, in `unit`."""

    unit: UnitSymbol
    """Unit of the scaled number."""
    scale: Annotated[float, Field(strict=False)] = 1.0
    """Factor of the instrument's number."""
    offset: Annotated[float, Field(strict=False)] = 0.0
    """Summand, added after scaling."""
    title: str = ""
    """Name in plots and reports."""

    @model_validator(mode="after")
    def _can_be_inverted(self) -> Self:
        if self.scale == 0:
            raise ValueError("scale is 0, expected any other number")
        return self

    @property
    def si_unit(self) -> str:
        """The symbol of the coherent SI unit."""
        return si_symbol(unit(self.unit).dimension)

    def to_si(self, number: _Number) -> _Number:
        """Return the quantity in SI for a number of the instrument, or for an array of them."""
        unit_ = unit(self.unit)
        return (number * self.scale + self.offset) * unit_.factor + unit_.offset

    def from_si(self, value: float) -> float:
        """Return the instrument's number for a quantity in SI."""
        unit_ = unit(self.unit)
        return ((value - unit_.offset) / unit_.factor - self.offset) / self.scale


class DeclaredChannel(DeclaredQuantity):
    """A channel of an instrument."""

    def info(self, name: str) -> ChannelInfo:
        """Return the description of the channel."""
        return ChannelInfo(name, self.si_unit, self.title or name, shown_in=self.unit)


class DeclaredReading(Settings):
    """A value of an instrument that is not a number: a text, a yes or no, an array."""

    kind: ReadingKind
    """text, boolean or array."""
    unit: UnitSymbol | None = None
    """For an array: the unit of its numbers."""
    title: str = ""
    """Name in plots and reports."""

    @model_validator(mode="after")
    def _has_its_unit(self) -> Self:
        if (self.kind == "array") != (self.unit is not None):
            needed = "needs a unit" if self.kind == "array" else "has no unit"
            raise ValueError(f"kind is {self.kind}, which {needed}")
        return self

    def reading_info(self, name: str) -> ReadingInfo:
        """Return the description of the reading."""
        symbol = si_symbol(unit(self.unit).dimension) if self.unit else ""
        return ReadingInfo(name, self.kind, self.title or name, symbol)

    def to_si(self, numbers: Sequence[float]) -> tuple[float, ...]:
        """Return the numbers of an array in the SI unit."""
        unit_ = unit(self.unit or "1")
        return tuple(number * unit_.factor + unit_.offset for number in numbers)


def refuse_other(where: str, texts: Mapping[str, str], expect: ExpectedIdentity) -> None:
    """Raise DeviceNotFoundError for the first part of the identity that is not as expected."""
    for part, expected in expect.items():
        if texts[part] != expected:
            raise DeviceNotFoundError(
                f"{where} has the {part} '{texts[part]}', expected '{expected}'",
                hint="is it another instrument, or must the station be updated?",
            )


def reading_infos(readings: Mapping[str, DeclaredReading]) -> tuple[ReadingInfo, ...]:
    """Return the descriptions of the readings."""
    return tuple(reading.reading_info(name) for name, reading in readings.items())


def refuse_shared_names(channels: Mapping[str, object], readings: Mapping[str, object]) -> None:
    """Raise ValueError for a reading with the name of a channel."""
    for name in readings:
        if name in channels:
            raise ValueError(f"'{name}' is a channel and a reading: give one another name")


class DeclaredDrive(DeclaredQuantity):
    """A drive of an instrument."""

    min: AnyQuantity
    """The lowest set-point."""
    max: AnyQuantity
    """The highest set-point."""
    safe: AnyQuantity
    """The safe value."""
    tolerance: Difference | None = None
    """Allowed deviation of the read-back from the set-point; if omitted, 1 % of the range."""
    rate: AnyQuantity | None = None
    """Its rate, such as 5 Hz/s; if omitted, it moves at once."""
    settle: Annotated[Duration, Field(ge=0)] = 10.0
    """Settling time, in addition to the time that the rate gives."""
    sets_cycle_frequency: YesNo = False
    """Whether it sets the frequency of the cyclic motion."""

    @model_validator(mode="after")
    def _is_one_quantity(self) -> Self:
        dimension = unit(self.unit).dimension
        for name in ("min", "max", "safe", "tolerance"):
            value: Quantity | None = getattr(self, name)
            if value is not None and value.dimension != dimension:
                raise ValueError(
                    f"{name} is '{value}', {with_article(value.dimension)}; expected"
                    f" {with_article(dimension)}"
                )
        if self.rate is not None and (
            self.rate.dimension != f"{dimension} rate" or self.rate.si <= 0
        ):
            raise ValueError(
                f"rate is '{self.rate}', expected {with_article(dimension)} rate above 0"
            )
        if not self.min.si <= self.safe.si <= self.max.si or self.min.si == self.max.si:
            raise ValueError(
                f"expected min <= safe <= max, got {self.min}, {self.safe}, {self.max}"
            )
        return self

    def info(self, name: str) -> DriveInfo:
        """Return the description of the drive."""
        return DriveInfo(
            name=name,
            unit=self.si_unit,
            long_name=self.title or name,
            minimum=self.min.si,
            maximum=self.max.si,
            rate_per_s=None if self.rate is None else self.rate.si,
            sets_cycle_frequency=self.sets_cycle_frequency,
            safe_value=self.safe.si,
            tolerance=None if self.tolerance is None else self.tolerance.si,
            settle_s=self.settle,
        )


def channel_infos(channels: Mapping[str, DeclaredChannel]) -> list[ChannelInfo]:
    """Return the descriptions of the channels."""
    return [channel.info(name) for name, channel in channels.items()]


def drive_infos(drives: Mapping[str, DeclaredDrive]) -> list[DriveInfo]:
    """Return the descriptions of the drives, in the order of making safe."""
    return [drive.info(name) for name, drive in drives.items()]
