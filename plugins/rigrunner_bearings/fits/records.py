"""The fit of the rig's torque by the drive's kinematics. Nothing here loads numpy."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import FitRecord, hookimpl
from rigrunner_bearings.fits import requirements

if TYPE_CHECKING:
    from rigrunner.api import Fit
    from rigrunner_bearings.fits.settings import InertiaPhysicalSettings


@hookimpl
def rigrunner_fits() -> list[FitRecord]:
    """Return the fit."""
    return [
        FitRecord(
            name="inertia_physical",
            help="Support friction, damping and inertia from the drive's kinematics",
            settings="rigrunner_bearings.fits.settings:InertiaPhysicalSettings",
            factory=_inertia_physical,
            requires=requirements.of_inertia_physical,
        ),
    ]


def _inertia_physical(settings: InertiaPhysicalSettings) -> Fit:
    from rigrunner_bearings.fits.inertia_physical import (  # noqa: PLC0415  (numpy)
        InertiaPhysicalFit,
    )

    return InertiaPhysicalFit(settings)
