"""The fit of the rig's torque by the drive's kinematics. Nothing here loads numpy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rigrunner.api import FitRecord, Requirements, hookimpl
from rigrunner_plugins.fits.requirements import least_points

if TYPE_CHECKING:
    from rigrunner.api import Fit
    from rigrunner_bearings.fits.settings import InertiaPhysicalSettings


COEFFICIENTS = 3
"""Friction, damping, inertia."""


@hookimpl
def rigrunner_fits() -> list[FitRecord]:
    """Return the fit."""
    return [
        FitRecord(
            name="inertia_physical",
            help="Support friction, damping and inertia from the drive's kinematics",
            settings="rigrunner_bearings.fits.settings:InertiaPhysicalSettings",
            factory=_inertia_physical,
            requires=_requirements,
        ),
    ]


def _inertia_physical(settings: InertiaPhysicalSettings) -> Fit:
    from rigrunner_bearings.fits.inertia_physical import (  # noqa: PLC0415  (numpy)
        InertiaPhysicalFit,
    )

    return InertiaPhysicalFit(settings)


def _requirements(_: Any) -> Requirements:
    return Requirements(points=least_points(COEFFICIENTS))
