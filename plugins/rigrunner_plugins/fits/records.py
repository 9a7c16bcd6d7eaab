"""The fits that ship; each `_name` function is a record's factory."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import FitRecord, hookimpl
from rigrunner_plugins.fits import requirements
from rigrunner_plugins.fits.examples import FILIP, MISRA, NO_INTERCEPT, NORRIS

if TYPE_CHECKING:
    from rigrunner.api import Fit, NoSettings
    from rigrunner_plugins.fits.settings import (
        AiccSettings,
        BasisSettings,
        ExpressionSettings,
        PolynomialSettings,
    )


@hookimpl
def rigrunner_fits() -> list[FitRecord]:
    """Return the shipped fits."""
    return [
        FitRecord(
            name="polynomial",
            help="Least-squares polynomial; of degree 2 it is the paper's Eq. (1)",
            settings="rigrunner_plugins.fits.settings:PolynomialSettings",
            factory=_polynomial,
            requires=requirements.of_polynomial,
            examples=(NORRIS, FILIP),
        ),
        FitRecord(
            name="basis",
            help="Least squares of chosen powers of x",
            settings="rigrunner_plugins.fits.settings:BasisSettings",
            trial={"powers": [0, 1, 2]},
            factory=_basis,
            requires=requirements.of_basis,
            examples=(NO_INTERCEPT,),
        ),
        FitRecord(
            name="aicc",
            help="The best of some sets of powers, by the corrected Akaike criterion",
            settings="rigrunner_plugins.fits.settings:AiccSettings",
            factory=_aicc,
            requires=requirements.of_aicc,
        ),
        FitRecord(
            name="expression",
            help="Least squares of a formula with parameters, of one or several variables",
            settings="rigrunner_plugins.fits.settings:ExpressionSettings",
            trial={
                "model": "T0 + b*f + J*f**2",
                "start": {"T0": "1 N·m", "b": "0.01 N·m/Hz", "J": "0.001 N·m/Hz²"},
            },
            factory=_expression,
            requires=requirements.of_expression,
            examples=(MISRA,),
        ),
        FitRecord(
            name="pchip",
            help="Monotone cubic through every point; no model, and no smoothing",
            factory=_pchip,
            requires=requirements.of_pchip,
        ),
    ]


def _polynomial(settings: PolynomialSettings) -> Fit:
    from rigrunner_plugins.fits.polynomial import PolynomialFit  # noqa: PLC0415  (numpy)

    return PolynomialFit(settings)


def _basis(settings: BasisSettings) -> Fit:
    from rigrunner_plugins.fits.polynomial import BasisFit  # noqa: PLC0415  (numpy)

    return BasisFit(settings)


def _aicc(settings: AiccSettings) -> Fit:
    from rigrunner_plugins.fits.polynomial import AiccFit  # noqa: PLC0415  (numpy)

    return AiccFit(settings)


def _expression(settings: ExpressionSettings) -> Fit:
    from rigrunner_plugins.fits.expression import ExpressionFit  # noqa: PLC0415  (scipy)

    return ExpressionFit(settings)


def _pchip(_: NoSettings) -> Fit:
    from rigrunner_plugins.fits.pchip import interpolate  # noqa: PLC0415  (scipy)

    return interpolate
