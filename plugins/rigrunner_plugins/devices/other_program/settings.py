"""Settings of a rig that another program controls."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from rigrunner.api import (
    AnyQuantity,
    ChannelInfo,
    DriveInfo,
    Frequency,
    Settings,
    UnitSymbol,
    YesNo,
    unit,
)
from rigrunner.api.units import si_symbol, with_article
from rigrunner_plugins.devices.declared import QuantityName


class OtherChannel(Settings):
    """A quantity that the other program records or reads."""

    unit: UnitSymbol
    """The unit of its values."""
    title: str = ""
    """Name in plots and reports."""

    def info(self, name: str) -> ChannelInfo:
        """Return the description of the channel."""
        si_unit = si_symbol(unit(self.unit).dimension)
        return ChannelInfo(name, si_unit, self.title or name, shown_in=self.unit)


class OtherDrive(Settings):
    """A quantity that the other program sets."""

    min: AnyQuantity
    """The lowest set-point."""
    max: AnyQuantity
    """The highest set-point."""
    title: str = ""
    """Name in plots and reports."""
    sets_cycle_frequency: YesNo = False
    """Whether it sets the frequency of the cyclic motion."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        if self.min.dimension != self.max.dimension:
            raise ValueError(
                f"'{self.min}' is {with_article(self.min.dimension)}, but '{self.max}' is not"
            )
        if self.min.si >= self.max.si:
            raise ValueError(f"min ({self.min}) must be below max ({self.max})")
        return self

    def info(self, name: str) -> DriveInfo:
        """Return the description of the drive."""
        return DriveInfo(
            name=name,
            unit=si_symbol(self.min.dimension),
            long_name=self.title or name,
            minimum=self.min.si,
            maximum=self.max.si,
            sets_cycle_frequency=self.sets_cycle_frequency,
            safe_value=min(max(self.min.si, 0.0), self.max.si),
        )


class OtherProgramSettings(Settings):
    """The channels and drives of a rig that another program controls."""

    program: Annotated[str, Field(min_length=1)]
    """Name of the program in messages."""
    rate: Annotated[Frequency, Field(gt=0, description="samples per second and channel")]
    channels: Annotated[dict[QuantityName, OtherChannel], Field(min_length=1)]
    """The channels by name."""
    drives: dict[QuantityName, OtherDrive] = Field(default_factory=dict)
    """The drives by name, in the order in which they are made safe."""
