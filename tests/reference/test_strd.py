"""Linear least squares against certified values of NIST's Statistical Reference Datasets."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from rigrunner.api.data import Points
from rigrunner_plugins.fits.basis import BasisFit
from rigrunner_plugins.fits.polynomial import PolynomialFit
from rigrunner_plugins.fits.settings import BasisSettings, PolynomialSettings

FOLDER = Path(__file__).parent / "strd"
NUMBER = r"(-?\d+\.?\d*(?:[Ee][+-]?\d+)?)"


@dataclass(frozen=True)
class Certified:
    y: np.ndarray
    x: np.ndarray
    estimates: np.ndarray
    standard_deviations: np.ndarray
    residual_s: float
    r_squared: float


def read(name) -> Certified:
    text = (FOLDER / f"{name}.dat").read_text()
    parameters = re.findall(rf"^\s+B\d\s+{NUMBER}\s+{NUMBER}\s*$", text, re.MULTILINE)
    start, end = map(int, re.search(r"Data\s+\(lines (\d+) to (\d+)\)", text).groups())
    data = np.array([line.split() for line in text.splitlines()[start - 1 : end]], float)
    estimates, deviations = np.array(parameters, float).T
    return Certified(
        y=data[:, 0],
        x=data[:, 1],
        estimates=estimates,
        standard_deviations=deviations,
        residual_s=float(re.search(rf"Standard Deviation\s+{NUMBER}", text)[1]),
        r_squared=float(re.search(rf"R-Squared\s+{NUMBER}", text)[1]),
    )


def digits(computed, certified):
    """Return the log relative error, the least over all values; log absolute error at zero."""
    computed, certified = np.atleast_1d(computed), np.atleast_1d(certified)
    error = np.abs(computed - certified) / np.where(certified == 0, 1, np.abs(certified))
    return float(-np.log10(np.maximum(error, 1e-16)).min())


POLYNOMIALS = [
    ("Norris", 1, 12),
    ("Pontius", 2, 12),
    ("Wampler1", 5, 9),
    ("Wampler2", 5, 12),
    ("Wampler3", 5, 9),
]


def least_digits_of(curve, nist):
    deviations = np.sqrt(np.diag(curve.covariance))
    return min(
        digits(curve.coefficients, nist.estimates),
        digits(deviations, nist.standard_deviations),
        digits(curve.residual_s, nist.residual_s),
        digits(curve.r_squared, nist.r_squared),
    )


@pytest.mark.parametrize(("name", "degree", "least_digits"), POLYNOMIALS)
def test_polynomials(name, degree, least_digits):
    nist = read(name)
    curve = PolynomialFit(PolynomialSettings(degree=degree))(Points(nist.x, nist.y))
    assert least_digits_of(curve, nist) >= least_digits


@pytest.mark.parametrize(("name", "degree", "least_digits"), POLYNOMIALS)
def test_the_same_powers_without_mapping(name, degree, least_digits):
    """A basis with gaps cannot be mapped; its powers are nearly dependent and scaled only."""
    nist = read(name)
    curve = BasisFit(BasisSettings(powers=range(degree + 1)))(Points(nist.x, nist.y))
    assert least_digits_of(curve, nist) >= least_digits


@pytest.mark.parametrize("name", ["NoInt1", "NoInt2"])
def test_without_an_intercept(name):
    nist = read(name)
    curve = BasisFit(BasisSettings(powers=[1]))(Points(nist.x, nist.y))
    assert least_digits_of(curve, nist) >= 13
