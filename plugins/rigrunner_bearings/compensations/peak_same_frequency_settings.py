"""What the compensation `peak_same_frequency` can be told; loads without numpy."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from rigrunner.api import Ratio, Settings


class PeakSameFrequencySettings(Settings):
    """Of the compensation `peak_same_frequency`."""

    frequency_match: Annotated[
        Ratio,
        Field(gt=0, le=0.05, description="how far the frequencies of a pair may differ"),
    ] = 0.01
