"""Settings of the faulty device: what is wrapped, and what goes wrong when; loads without numpy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api import AnyQuantity, ListOf, Ratio, Settings, WrapperSettings
from rigrunner.api.units import with_article
from rigrunner_plugins.devices.fields import quantity

Call = Literal["connect", "set", "read back", "read", "stream", "make safe"]
Kind = Literal[
    "timeout",
    "late",
    "lost",
    "rejected",
    "nan",
    "stuck",
    "clipped",
    "spikes",
    "drift",
    "noise",
    "sensitivity",
    "wrong frequency",
    "dropped blocks",
    "repeated block",
    "wrong order",
    "gap",
    "hidden gap",
    "time back",
]
CHANNELS_UNIT = "of the channel"
"""Stands for the dimension of what the channel, or the drive, measures."""


@dataclass(frozen=True)
class Nature:
    """Of one kind of fault: which calls it may affect, the first by default, and its extent."""

    calls: tuple[Call, ...] = ("stream",)
    dimension: str = ""
    """Of the extent; empty: it has none."""
    default_si: float | None = None
    """Of the extent; None where the station has to say."""
    share: float = 0.0
    """Share of a recording that it affects, where nothing else is said."""


_ANSWERS: tuple[Call, ...] = ("stream", "connect", "set", "read back", "read", "make safe")
NATURES: dict[Kind, Nature] = {
    "timeout": Nature(_ANSWERS, "time", 1.0),
    "late": Nature(_ANSWERS, "time", 5.0),
    "lost": Nature(_ANSWERS),
    "rejected": Nature(_ANSWERS),
    "nan": Nature(("stream", "read", "read back")),
    "stuck": Nature(("stream", "set"), share=0.1),
    "clipped": Nature(dimension=CHANNELS_UNIT),
    "spikes": Nature(dimension=CHANNELS_UNIT, share=0.001),
    "drift": Nature(dimension=CHANNELS_UNIT),
    "noise": Nature(dimension=CHANNELS_UNIT),
    "sensitivity": Nature(dimension="ratio"),
    "wrong frequency": Nature(("set",), "ratio"),
    "dropped blocks": Nature(),
    "repeated block": Nature(),
    "wrong order": Nature(),
    "gap": Nature(dimension="time", default_si=1.0),
    "hidden gap": Nature(dimension="time", default_si=0.01),
    "time back": Nature(dimension="time", default_si=1.0),
}


class FaultSettings(Settings):
    """One fault: its kind, the call that it affects, and when."""

    kind: Annotated[Kind, Field(description="what goes wrong")]
    on: Annotated[
        Call | None, Field(description="affected call; if omitted, the usual one of the kind")
    ] = None
    channel: Annotated[str, Field(description="the channel of a stream that it affects")] = "torque"
    drive: Annotated[str, Field(description="drive of set and read back; if omitted, any")] = ""
    at: Annotated[
        dict[str, AnyQuantity],
        Field(description="set-points by drive, such as 10 Hz: it acts only while they are set"),
    ] = Field(default_factory=dict)
    calls: Annotated[
        ListOf[Annotated[int, Field(ge=1)]],
        Field(description="the numbers of the affected calls, from 1; default: all"),
    ] = ()
    probability: Ratio = quantity("100 %", "probability that it affects a call", ge=0, le=1)
    extent: Annotated[
        AnyQuantity | None, Field(description="size of the fault; its unit depends on the kind")
    ] = None
    share: Annotated[
        Ratio | None, Field(ge=0, le=1, description="share of a recording that it affects")
    ] = None

    @property
    def call(self) -> Call:
        """The call that it affects."""
        return self.on or NATURES[self.kind].calls[0]

    @property
    def extent_si(self) -> float:
        """How much, in the SI unit of its dimension; 0 where the kind has no extent."""
        if self.extent is not None:
            return self.extent.si
        return NATURES[self.kind].default_si or 0.0

    @property
    def part(self) -> float:
        """Share of a recording that it affects, from 0 to 1."""
        return NATURES[self.kind].share if self.share is None else self.share

    @model_validator(mode="after")
    def _fits_its_kind(self) -> Self:
        nature = NATURES[self.kind]
        if self.call not in nature.calls:
            allowed = ", ".join(nature.calls)
            raise ValueError(f"'{self.kind}' does not affect '{self.call}', allowed: {allowed}")
        if self.extent is None and nature.dimension and nature.default_si is None:
            kind = nature.dimension.replace("of the channel", "quantity in the channel's unit")
            raise ValueError(f"'{self.kind}' needs an extent: a {kind}")
        if self.extent is not None and not nature.dimension:
            raise ValueError(f"'{self.kind}' has no extent, got '{self.extent}'")
        # That of the channel is checked once the device is known.
        dimension = nature.dimension
        if self.extent is not None and dimension not in (CHANNELS_UNIT, self.extent.dimension):
            raise ValueError(
                f"'{self.kind}': extent: got '{self.extent}', expected {with_article(dimension)}"
            )
        return self


class FaultyDeviceSettings(WrapperSettings):
    """A device of another plugin, and its faults."""

    seed: Annotated[int, Field(ge=0, description="seed of the random numbers")] = 0
    faults: Annotated[ListOf[FaultSettings], Field(description="what goes wrong, and when")] = ()
