"""How many points each fit needs; loads without numpy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rigrunner.api import Requirements

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner_plugins.fits.settings import (
        AiccSettings,
        BasisSettings,
        ExpressionSettings,
        PolynomialSettings,
    )

LEAST_OF_PCHIP = 3


def least_points(coefficients: int) -> int:
    """Return how many different frequencies give so many coefficients with their uncertainty."""
    return coefficients + 1


def least_points_of_aicc(coefficients: int) -> int:
    """Return how many points the criterion needs: the residual's variance is a parameter too."""
    return coefficients + 3


def of_polynomial(settings: PolynomialSettings) -> Requirements:
    """Return what the fit `polynomial` needs."""
    powers = range(settings.degree + 1)
    return Requirements(points=least_points(len(powers)), parameters=_coefficients(powers))


def of_basis(settings: BasisSettings) -> Requirements:
    """Return what the fit `basis` needs."""
    powers = settings.powers
    return Requirements(points=least_points(len(powers)), parameters=_coefficients(powers))


def of_aicc(settings: AiccSettings) -> Requirements:
    """Return what the fit `aicc` needs: points for the smallest of its candidates."""
    smallest = min(len(powers) for powers in settings.candidates)
    return Requirements(points=least_points_of_aicc(smallest))


def of_expression(settings: ExpressionSettings) -> Requirements:
    """Return what the fit `expression` needs."""
    units = {name: start.unit for name, start in settings.start.items()}
    return Requirements(points=least_points(len(units)), parameters=units)


def _coefficients(powers: Iterable[int]) -> dict[str, str]:
    return {f"c{power}": "" for power in powers}


def of_pchip(_: Any) -> Requirements:
    """Return what the fit `pchip` needs."""
    return Requirements(points=LEAST_OF_PCHIP)
