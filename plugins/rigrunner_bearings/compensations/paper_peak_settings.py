"""What the compensation `paper_peak` can be told; loads without numpy."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from rigrunner.api import Settings


class PaperPeakSettings(Settings):
    """Of the compensation `paper_peak`."""

    coefficients: Annotated[
        Literal["published", "refit"],
        Field(description="of Eq. (1): the authors' rig, or fitted to this rig's no-load run"),
    ] = "refit"
