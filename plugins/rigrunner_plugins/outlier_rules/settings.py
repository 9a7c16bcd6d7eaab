"""What the rules for gross errors can be told; loads without numpy."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from rigrunner.api.settings import Settings


class GrubbsSettings(Settings):
    """Of the rule `grubbs`."""

    alpha: Annotated[
        float,
        Field(gt=0, lt=0.5, description="risk of rejecting one of n good values (not each)"),
    ] = 0.05
    side: Annotated[
        Literal["both", "high", "low"], Field(description="which extreme is suspected")
    ] = "both"
