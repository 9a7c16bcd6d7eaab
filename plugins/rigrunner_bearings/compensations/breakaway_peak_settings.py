"""What the compensation `breakaway_peak` can be told; loads without numpy."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from rigrunner.api import Settings, Torque


class BreakawayPeakSettings(Settings):
    """Of the compensation `breakaway_peak`."""

    fixture_friction: Annotated[
        Torque,
        Field(ge=0, description="the most that the bench's own supports add; half is taken off"),
    ] = 0.0
