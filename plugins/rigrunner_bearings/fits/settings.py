"""The settings of the fit; loads without numpy."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from rigrunner.api import Length  # noqa: TC001  (pydantic reads it)
from rigrunner_plugins.fits.settings import WeightedSettings


class InertiaPhysicalSettings(WeightedSettings):
    """Of the fit `inertia_physical`: the drive's geometry, as the station has it."""

    eccentric: Annotated[Length, Field(gt=0)] = 0.002
    """How far the crank pin is from the crank's axis."""
    centre_distance: Annotated[Length, Field(gt=0)] = 0.045
    """Between the axes of crank and swing."""
