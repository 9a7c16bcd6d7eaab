"""The fits that ship."""

from __future__ import annotations

from rigrunner.api import FitRecord, Imported, hookimpl
from rigrunner_plugins.fits import requirements
from rigrunner_plugins.fits.examples import FILIP, MISRA, NO_INTERCEPT, NORRIS


@hookimpl
def rigrunner_fits() -> list[FitRecord]:
    """Return the shipped fits."""
    return [
        FitRecord(
            name="polynomial",
            help="Least-squares polynomial; of degree 2 it is the paper's Eq. (1)",
            settings="rigrunner_plugins.fits.settings:PolynomialSettings",
            factory=Imported("rigrunner_plugins.fits.polynomial:PolynomialFit"),
            requires=requirements.of_polynomial,
            examples=(NORRIS, FILIP),
        ),
        FitRecord(
            name="basis",
            help="Least squares of chosen powers of x",
            settings="rigrunner_plugins.fits.settings:BasisSettings",
            trial={"powers": [0, 1, 2]},
            factory=Imported("rigrunner_plugins.fits.polynomial:BasisFit"),
            requires=requirements.of_basis,
            examples=(NO_INTERCEPT,),
        ),
        FitRecord(
            name="aicc",
            help="The best of some sets of powers, by the corrected Akaike criterion",
            settings="rigrunner_plugins.fits.settings:AiccSettings",
            factory=Imported("rigrunner_plugins.fits.polynomial:AiccFit"),
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
            factory=Imported("rigrunner_plugins.fits.expression:ExpressionFit"),
            requires=requirements.of_expression,
            examples=(MISRA,),
        ),
        FitRecord(
            name="pchip",
            help="Monotone cubic through every point; no model, and no smoothing",
            factory=Imported("rigrunner_plugins.fits.pchip:interpolate", called=False),
            requires=requirements.of_pchip,
        ),
    ]
