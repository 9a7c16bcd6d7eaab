"""The result of a gauge study of the rig, as entered in its station."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from rigrunner.api.settings import PlainText, Settings, Torque


class Scatter(Settings):
    """A standard deviation from a study."""

    u: Annotated[Torque, Field(ge=0, description="the standard deviation of one result")]
    degrees_of_freedom: Annotated[float, Field(ge=1, description="as the study states them")]


class NamedStudy(Settings):
    """A gauge study of this rig; `rigrunner gauge-rr` prints the entry."""

    source: Annotated[
        PlainText, Field(min_length=1, max_length=80, description="the study: its date or report")
    ]
    between_mountings: Annotated[
        Scatter | None,
        Field(description="the study's repeatability, where each trial was mounted again"),
    ] = None
    reproducibility: Annotated[
        Scatter | None, Field(description="between operators, with their interaction")
    ] = None
