"""The fits of torque over frequency that ship; each `_name` function is a record's factory."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.hooks import FitRecord, hookimpl
from rigrunner_plugins.fits.settings import InertiaPhysicalSettings, PolynomialSettings

if TYPE_CHECKING:
    from rigrunner.api.analysis import Fit


@hookimpl
def rigrunner_fits() -> list[FitRecord]:
    """Return the fits of torque over frequency."""
    return [
        FitRecord(
            name="polynomial",
            help="Least-squares polynomial; of degree 2 it is the paper's Eq. (1)",
            settings=PolynomialSettings,
            factory=_polynomial,
        ),
        FitRecord(
            name="inertia_physical",
            help="Support friction, damping and inertia from the drive's kinematics",
            settings=InertiaPhysicalSettings,
            factory=_inertia_physical,
        ),
    ]


def _polynomial(settings: PolynomialSettings) -> Fit:
    from rigrunner_plugins.fits.polynomial import PolynomialFit  # noqa: PLC0415  (numpy)

    return PolynomialFit(settings)


def _inertia_physical(settings: InertiaPhysicalSettings) -> Fit:
    from rigrunner_plugins.fits.inertia_physical import (  # noqa: PLC0415  (numpy)
        InertiaPhysicalFit,
    )

    return InertiaPhysicalFit(settings)
