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
    """Settings of the rule `grubbs`."""

    alpha: Risk = 0.05
    side: Annotated[
        Literal["both", "high", "low"], Field(description="which extreme is tested")
    ] = "both"


class GeneralizedEsdSettings(Settings):
    """Settings of the rule `generalized_esd`."""

    alpha: Risk = 0.05
    at_most: Annotated[
        int,
        Field(
            ge=1, description="largest number of gross errors to search for; at most a fifth of n"
        ),
    ] = 10


class MadSettings(Settings):
    """Settings of the rule `mad`."""

    threshold: Annotated[
        float,
        Field(gt=0, description="largest distance from the median, in robust standard deviations"),
    ] = 3.5
