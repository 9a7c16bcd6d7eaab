"""Least squares against certified values of NIST's Statistical Reference Datasets."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import numpy as np
import pytest

from rigrunner.api.data import Points
from rigrunner.api.errors import DataError
from rigrunner_plugins.fits.polynomial import BasisFit, PolynomialFit
from rigrunner_plugins.fits.settings import BasisSettings, PolynomialSettings

ROOT = Path(__file__).parents[2]
strd = runpy.run_path(str(ROOT / "docs/evidence/strd_page.py"))
read, digits = strd["read"], strd["digits"]
LONGEST_DOUBLE = np.finfo(np.longdouble).nmant >= 63
"""Where extended precision is double precision, there are fewer digits."""


POLYNOMIALS = [
    ("Norris", 1, 12),
    ("Pontius", 2, 12),
    ("Wampler1", 5, 9),
    ("Wampler2", 5, 12),
    ("Wampler3", 5, 9),
    ("Filip", 10, 13),
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
    curve = PolynomialFit(PolynomialSettings(degree=degree))(nist.points)
    assert least_digits_of(curve, nist) >= least_digits


@pytest.mark.parametrize(("name", "degree", "least_digits"), POLYNOMIALS[:-1])
def test_powers_without_mapping(name, degree, least_digits):
    """A basis with gaps cannot be mapped; its nearly dependent powers are only scaled."""
    nist = read(name)
    curve = BasisFit(BasisSettings(powers=range(degree + 1)))(nist.points)
    assert least_digits_of(curve, nist) >= least_digits


@pytest.mark.parametrize(("times", "least_digits"), [(1e2, 10), (1e4, 8)])
def test_wampler_4_and_5(times, least_digits):
    """The errors of Wampler3 times 100 and 10,000; the curve is still that of Wampler1."""
    exact, noisy = read("Wampler1").points, read("Wampler3")
    y = exact.y + times * (noisy.points.y - exact.y)
    curve = PolynomialFit(PolynomialSettings(degree=5))(Points(exact.x, y))
    deviations = times * noisy.standard_deviations
    assert digits(curve.coefficients, noisy.estimates) >= least_digits
    assert digits(np.sqrt(np.diag(curve.covariance)), deviations) >= 12


@pytest.mark.parametrize("name", ["NoInt1", "NoInt2"])
def test_without_an_intercept(name):
    nist = read(name)
    curve = BasisFit(BasisSettings(powers=[1]))(nist.points)
    assert least_digits_of(curve, nist) >= 13


def test_nearly_equal_points_do_not_count_as_many():
    """Twelve frequencies at three set-points, 6 mHz apart: they allow a line, but not degree 10."""
    x = np.add.outer([10.0, 20.0, 30.0], [0.0, 6e-3, 12e-3, 18e-3]).ravel()
    points = Points(x, 1 + x**2)
    PolynomialFit(PolynomialSettings(degree=1))(points)
    with pytest.raises(DataError, match="needs 12 different values of f, got 3"):
        PolynomialFit(PolynomialSettings(degree=10))(points)


@pytest.mark.parametrize("degree", [9, 10])
def test_degree_beyond_the_data_is_refused(degree):
    """Ten different x give a polynomial of degree 8 with its uncertainty, and no more."""
    filip = read("Filip").points
    few = Points(filip.x[:11], filip.y[:11], x_unit="s")
    PolynomialFit(PolynomialSettings(degree=8))(few)
    needs = f"needs {degree + 2} different values of f, got 10"
    with pytest.raises(DataError, match=needs):
        PolynomialFit(PolynomialSettings(degree=degree))(few)


def test_several_regressors():
    """Longley's six nearly dependent regressors."""
    assert least_digits_of(strd["fitted"](read("Longley")), read("Longley")) >= 13


def test_all_nonlinear_sets_are_present():
    assert len(strd["nonlinear"]()) == 27


@pytest.mark.skipif(not LONGEST_DOUBLE, reason="extended precision is double precision here")
@pytest.mark.parametrize("start", [1, 2])
@pytest.mark.parametrize("name", strd["nonlinear"]())
def test_nonlinear_sets(name, start):
    nist = read(name)
    curve = strd["fitted"](nist, start)
    assert digits(curve.coefficients, nist.estimates) >= 10.5
    exact = name == "Lanczos1"  # residuals of 1e-13, of data that are rounded at 1e-16
    minimum = 3 if exact else 10
    assert digits(np.sqrt(np.diag(curve.covariance)), nist.standard_deviations) >= minimum
    assert digits(curve.residual_s, nist.residual_s) >= minimum
    assert curve.dof == len(nist.points.y) - len(nist.estimates)


@pytest.mark.thorough
@pytest.mark.skipif(not LONGEST_DOUBLE, reason="extended precision is double precision here")
def test_page_shows_computed_digits():
    stored, computed = (
        re.split(r"(\d+\.\d)(?= [|/])", text)
        for text in ((ROOT / "docs/evidence/strd.md").read_text("utf-8"), strd["page"]())
    )
    command = "python docs/evidence/strd_page.py docs/evidence"
    assert stored[::2] == computed[::2], command
    assert np.array(stored[1::2], float) == pytest.approx(
        np.array(computed[1::2], float), abs=0.5
    ), command
