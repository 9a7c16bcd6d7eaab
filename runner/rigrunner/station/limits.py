"""Limits of a station for its drives: range, rate, combinations."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from rigrunner.api.member import Member
from rigrunner.api.quantity import legible
from rigrunner.api.settings import AnyQuantity, ListOf, PlainText, Settings
from rigrunner.api.units import si_symbol

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.devices import DriveInfo

_ROUNDING = 1 + 1e-9
"""A corner in kN may be a little lower in N than the set-point that it allows, by rounding."""


class DriveLimits(Settings):
    """A smaller range, or a lower rate, than that of the device."""

    min: AnyQuantity | None = None
    """The lowest set-point."""
    max: AnyQuantity | None = None
    """The highest set-point."""
    rate: AnyQuantity | None = None
    """Highest rate; a faster drive is moved in steps."""

    @model_validator(mode="after")
    def _check_not_empty(self) -> Self:
        if not self.model_fields_set:
            raise ValueError("a limit needs min, max or rate")
        return self

    def narrowed(self, info: DriveInfo) -> DriveInfo:
        """Return the drive with the tighter of its own limits and these."""
        low = info.minimum if self.min is None else max(info.minimum, self.min.si)
        high = info.maximum if self.max is None else min(info.maximum, self.max.si)
        rates = [rate for rate in (info.rate_per_s, self.rate and self.rate.si) if rate]
        return replace(info, minimum=low, maximum=high, rate_per_s=min(rates, default=None))


class Combination(Settings):
    """Drives that must not all be high at the same time, such as load and frequency."""

    allowed: Annotated[
        ListOf[Annotated[dict[Member, AnyQuantity], Field(min_length=2)]], Field(min_length=1)
    ]
    """Corners: the drives may have all values up to those of one corner, in magnitude, at the same
    time."""
    reason: PlainText = ""
    """The reason, shown in refusals."""

    @model_validator(mode="after")
    def _check_corners(self) -> Self:
        for corner in self.allowed[1:]:
            if set(corner) != set(self.drives):
                expected, actual = ", ".join(self.drives), ", ".join(corner)
                raise ValueError(f"a corner is about {actual}, the first one about {expected}")
        return self

    @property
    def drives(self) -> tuple[Member, ...]:
        """The drives concerned, 'role.drive'."""
        return tuple(self.allowed[0])

    def allows(self, values: Mapping[Member, float]) -> bool:
        """Return whether the drives may have these values, in SI units, at the same time.

        The allowed region is a union of boxes around zero: moving one drive at a time between two
        allowed points can stay inside.
        """
        return any(
            all(abs(values[name]) <= high.si * _ROUNDING for name, high in corner.items())
            for corner in self.allowed
        )

    def others(self, member: Member, values: Mapping[Member, float]) -> str:
        """Return the values of the other drives as text; `values` are in SI units."""
        units = {name: si_symbol(high.dimension) for name, high in self.allowed[0].items()}
        others = (name for name in self.drives if name != member)
        return ", ".join(f"{name} at {legible(values[name], units[name])}" for name in others)

    def words(self) -> str:
        """Return the allowed region as text."""
        return " or ".join(
            " with ".join(f"{name} up to {high}" for name, high in corner.items())
            for corner in self.allowed
        )
