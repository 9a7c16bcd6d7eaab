"""How many points the fit needs; loads without numpy."""

from __future__ import annotations

from typing import Any

from rigrunner.api import Requirements
from rigrunner_plugins.fits.requirements import least_points

COEFFICIENTS = 3
"""Friction, damping, inertia."""


def of_inertia_physical(_: Any) -> Requirements:
    """Return what the fit `inertia_physical` needs."""
    return Requirements(points=least_points(COEFFICIENTS))
