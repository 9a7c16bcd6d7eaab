"""Settings of the composite: which parts it has, and what its channels and drives are of them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import AfterValidator, Field, model_validator

from rigrunner.api import Duration, PositiveDuration, Settings, WrapperSettings
from rigrunner.api.settings import Difference, MadeOfOthers
from rigrunner_plugins.devices.declared import QuantityName, refuse_shared_names

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

_PLACE = r"[a-z][a-z0-9_]*\.[a-z][a-z0-9_]*"


def _place(text: str) -> str:
    if not re.fullmatch(_PLACE, text):
        raise ValueError(f"'{text[:40]}' is not of the form part.name, such as daq.torque")
    return text


Place = Annotated[str, AfterValidator(_place), Field(json_schema_extra={"pattern": f"^{_PLACE}$"})]
"""A channel or a drive of a part: `part.name`."""


class PartSettings(WrapperSettings):
    """One instrument of the role: its plugin, with settings."""


class DriveSource(Settings):
    """A drive that one part sets and another one measures."""

    set: Place
    """The drive that is set, such as press.load."""
    read_back: Place
    """The channel of its actual value, such as cell.force."""
    tolerance: Difference | None = None
    """Allowed deviation from the set-point; if omitted, that of the drive."""


class ClockSettings(Settings):
    """How the clocks of parts that are recorded together are aligned."""

    reference: QuantityName | None = None
    """The part whose sample times a recording uses, the fastest; if omitted, that of the first
    channel."""
    common: dict[QuantityName, QuantityName] = Field(default_factory=dict)
    """For each part, the channel in which all record the same signal."""
    lead: PositiveDuration = 1.0
    """How long the clocks are compared before a recording begins."""
    latency: Annotated[Duration, Field(ge=0)] = 0.01
    """Greatest delay of the earliest block of a stream after its last sample."""


class CompositeSettings(MadeOfOthers):
    """One role from several instruments."""

    parts: Annotated[dict[QuantityName, PartSettings], Field(min_length=1)]
    """The instruments by name; they are connected in this order."""
    channels: dict[QuantityName, Place] = Field(default_factory=dict)
    """Each channel of the role and its part: torque: daq.torque."""
    readings: dict[QuantityName, Place] = Field(default_factory=dict)
    """Each reading of the role that is not a number, and its part: door: plc.door."""
    drives: dict[QuantityName, Place | DriveSource] = Field(default_factory=dict)
    """Each drive of the role and its part; parts are made safe in this order."""

    clocks: ClockSettings = Field(default_factory=ClockSettings)
    """How channels of several parts are recorded together."""

    def others(self) -> Mapping[tuple[str, ...], WrapperSettings]:
        """Return the parts."""
        return {("parts", name): part for name, part in self.parts.items()}

    def source(self, channel: str) -> tuple[WrapperSettings, str] | None:
        """Return the part that gives a channel."""
        if channel not in self.channels:
            return None
        part, name = split(self.channels[channel])
        return self.parts[part], name

    @model_validator(mode="after")
    def _names_its_parts(self) -> Self:
        refuse_shared_names(self.channels, self.readings)
        for what, place in self._places():
            if split(place)[0] not in self.parts:
                names = ", ".join(self.parts)
                raise ValueError(f"{what}: '{place}' belongs to no part; the parts are: {names}")
        return self

    @model_validator(mode="after")
    def _compares_its_parts(self) -> Self:
        names = [*self.clocks.common, *([self.clocks.reference] if self.clocks.reference else [])]
        for part in names:
            if part not in self.parts:
                part_names = ", ".join(self.parts)
                raise ValueError(f"clocks: there is no part '{part}'; the parts are: {part_names}")
        return self

    def _places(self) -> Iterator[tuple[str, str]]:
        for name, place in self.channels.items():
            yield f"channel {name}", place
        for name, place in self.readings.items():
            yield f"reading {name}", place
        for name, source in self.drives.items():
            if isinstance(source, DriveSource):
                yield f"drive {name}", source.set
                yield f"drive {name}", source.read_back
            else:
                yield f"drive {name}", source


def split(place: str) -> tuple[str, str]:
    """Return the part and the name of its channel or drive."""
    part, _, name = place.partition(".")
    return part, name
