"""The settings of the fit; loads without numpy."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from rigrunner.api import Length  # noqa: TC001  (pydantic reads it)
from rigrunner_plugins.fits.settings import WeightedSettings


class InertiaPhysicalSettings(WeightedSettings):
    """Settings of the fit `inertia_physical`: the drive's geometry, as in the station."""

    eccentric: Annotated[Length, Field(gt=0)] = 0.002
    """Distance of the crank pin from the crank's axis."""
    centre_distance: Annotated[Length, Field(gt=0)] = 0.045
    """Distance between the axes of crank and swing."""
