"""The fit of the rig's torque by the drive's kinematics. Nothing here loads numpy."""

from __future__ import annotations

from rigrunner.api import FitRecord, Imported, Requirements, hookimpl
from rigrunner_plugins.fits.requirements import least_points

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
            factory=Imported("rigrunner_bearings.fits.inertia_physical:InertiaPhysicalFit"),
            requires=lambda _: Requirements(points=least_points(COEFFICIENTS)),
        ),
    ]
