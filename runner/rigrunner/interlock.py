"""Interlocks: the monitored channel, its allowed values, and the action outside them."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api.member import Member
from rigrunner.api.names import Name
from rigrunner.api.quantity import Quantity
from rigrunner.api.settings import (
    AnyQuantity,
    Difference,
    Duration,
    ListOf,
    PositiveDuration,
    Settings,
    YesNo,
)

CONDITIONS = ("above", "below", "outside", "rate", "stale")


class Interlock(Settings):
    """A channel monitored throughout a run. One of above, below, outside, rate, stale."""

    name: Name
    """Name in alarms."""
    channel: Member
    """Channel that is monitored, such as tester.temperature."""
    above: AnyQuantity | None = None
    """It trips above this value."""
    below: AnyQuantity | None = None
    """It trips below this value."""
    outside: Annotated[ListOf[AnyQuantity] | None, Field(min_length=2, max_length=2)] = None
    """It trips outside this range, such as [15 °C, 30 °C]."""
    rate: AnyQuantity | None = None
    """It trips at a faster change, up or down, such as 2 K/s."""
    stale: PositiveDuration | None = None
    """It trips if it could not be read for this time; the other conditions then trip at once. An
    unchanged value is not an error: `stale` of a device, such as opcua or serial_ascii, limits its
    age, and an older value cannot be read."""
    debounce: Annotated[Duration, Field(ge=0)] = 0.0
    """How long the condition must last without interruption."""
    hysteresis: Difference | None = None
    """How far within its limit a value must be to clear it."""
    latched: YesNo = False
    """Whether it stays tripped for the rest of the run."""
    every: PositiveDuration = 0.1
    """Interval between readings of the channel; of a recording every sample is checked."""
    does: Literal["forbid", "pause", "abort", "make_safe"] = "abort"
    """Its action in addition to `forbids`: pause or abort the run, or make safe at once and
    abort."""
    forbids: ListOf[Member] = ()
    """Drives that may not move away from their safe value while it is tripped; moving back is
    allowed."""
    overridable: YesNo = False
    """Whether a person may resume, with a reason, while it is tripped."""

    @model_validator(mode="after")
    def _has_one_condition(self) -> Self:
        conditions = [name for name in CONDITIONS if getattr(self, name) is not None]
        if len(conditions) != 1:
            names = " and ".join(conditions) or "none"
            raise ValueError(f"got {names}, expected one of: {', '.join(CONDITIONS)}")
        kinds = {quantity.dimension for quantity in self.outside or ()}
        if self.outside and len(kinds) == 1 and self.outside[0].si >= self.outside[1].si:
            raise ValueError(f"{self.outside[0]} must be below {self.outside[1]}")
        if self.does == "forbid" and not self.forbids:
            raise ValueError("'does: forbid' needs the drives that it forbids")
        if self.rate is not None and self.rate.si <= 0:
            raise ValueError(
                f"rate: got '{self.rate}', expected more than 0; it trips at a change up or down"
            )
        if self.hysteresis is not None and not self.bounds:
            raise ValueError("hysteresis is a distance from above, below or outside")
        if self.hysteresis is not None and self.outside and len(kinds) == 1:
            width = self.outside[1].si - self.outside[0].si
            if 2 * self.hysteresis.si >= width:
                raise ValueError(
                    f"got a hysteresis of {self.hysteresis}, expected less than half of"
                    f" {self.outside[0]} to {self.outside[1]}; it would never clear"
                )
        return self

    @property
    def bounds(self) -> dict[str, Quantity]:
        """The lowest and the highest value that is allowed, as 'minimum' and 'maximum'."""
        low, high = self.outside or (self.below, self.above)
        bounds = {"minimum": low, "maximum": high}
        return {name: quantity for name, quantity in bounds.items() if quantity is not None}

    @property
    def condition(self) -> str:
        """What trips it, in words, such as 'above 60 °C'."""
        match self:
            case Interlock(outside=(low, high)):
                return f"outside {low} to {high}"
            case Interlock(rate=Quantity() as rate):
                return f"faster than {rate}"
            case Interlock(stale=float() as stale):
                return f"not read for {stale:g} s"
            case _:
                return f"above {self.above}" if self.above else f"below {self.below}"
