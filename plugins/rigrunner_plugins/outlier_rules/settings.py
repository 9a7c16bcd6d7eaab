"""Settings of the rules for gross errors; loads without numpy."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from rigrunner.api import Settings

Risk = Annotated[
    float,
    Field(gt=0, lt=0.5, description="risk of rejecting any of n good values (not each)"),
]


class GrubbsSettings(Settings):
    """Of the rule `grubbs`."""

    alpha: Risk = 0.05
    side: Annotated[
        Literal["both", "high", "low"], Field(description="which extreme is suspected")
    ] = "both"


class GeneralizedEsdSettings(Settings):
    """Of the rule `generalized_esd`."""

    alpha: Risk = 0.05
    at_most: Annotated[
        int, Field(ge=1, description="how many gross errors to look for; never over a fifth of n")
    ] = 10


class MadSettings(Settings):
    """Of the rule `mad`."""

    threshold: Annotated[
        float, Field(gt=0, description="in robust standard deviations from the median")
    ] = 3.5
