"""What the fits can be told; loads without numpy."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from rigrunner.api.settings import Length, Settings


class PolynomialSettings(Settings):
    """Of the fit `polynomial`."""

    degree: Annotated[int, Field(ge=1, le=8)] = 2
    weighted: Annotated[
        bool, Field(description="weigh each point by 1/u^2; the paper's fit does not")
    ] = False


class InertiaPhysicalSettings(Settings):
    """Of the fit `inertia_physical`: the drive's geometry, as the station has it."""

    eccentric: Annotated[Length, Field(gt=0)] = 0.002
    centre_distance: Annotated[Length, Field(gt=0)] = 0.045
