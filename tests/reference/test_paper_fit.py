"""The paper's quadratic, recomputed (Wang et al., Machines 2025, 13(11), 976, Table 2, Eq. 1)."""

from __future__ import annotations

from fractions import Fraction
from math import log

import numpy as np
import pytest

from reference.helpers_exact import exact_least_squares
from rigrunner.api.data import Points
from rigrunner_bearings.compensations.paper_peak import published_curve
from rigrunner_plugins.fits.polynomial import AiccFit, BasisFit, PolynomialFit
from rigrunner_plugins.fits.settings import AiccSettings, BasisSettings, PolynomialSettings

TABLE_2_HZ = [1, 5, 10, 15, 20, 25, 30, 35]
TABLE_2_NM = ["0.83", "1.21", "1.64", "2.32", "3.01", "3.96", "5.12", "6.91"]


@pytest.fixture
def curve():
    points = Points(np.array(TABLE_2_HZ, float), np.array(TABLE_2_NM, float))
    return PolynomialFit(PolynomialSettings())(points)


def test_coefficients_equal_exact_fractions(curve):
    exact = exact_least_squares([[1, f, f * f] for f in TABLE_2_HZ], TABLE_2_NM).coefficients
    assert exact[2] == Fraction(97813, 24141600)
    assert exact[1] == Fraction(1785697, 72424800)
    assert exact[0] == Fraction(5536529, 6035400)
    assert curve.coefficients == pytest.approx([float(value) for value in exact], rel=1e-13)


def test_rounded_coefficients_equal_equation_1(curve):
    assert curve.coefficients.round(4).tolist() == [0.9173, 0.0247, 0.0041]


def test_goodness_of_fit(curve):
    assert np.sum(curve.residuals**2) == pytest.approx(0.11088321928400216, rel=1e-12)
    assert curve.dof == 5
    assert curve.residual_s == pytest.approx(0.1489182455, abs=5e-11)
    assert curve.r_squared == pytest.approx(0.9964003863, abs=5e-11)


def test_uncertainty_and_correlation_of_coefficients(curve):
    u = np.sqrt(np.diag(curve.covariance))
    assert u == pytest.approx([0.13527251, 0.01801029, 0.00048683], abs=5e-9)
    correlation = curve.covariance / np.outer(u, u)
    assert correlation[2, 1] == pytest.approx(-0.965764, abs=5e-7)
    assert correlation[2, 0] == pytest.approx(0.691316, abs=5e-7)
    assert correlation[1, 0] == pytest.approx(-0.825575, abs=5e-7)


def test_published_coefficients_miss_table_2_by_five_percent_on_average():
    """The paper's '1.53 %' is the 35 Hz point alone."""
    table = np.array(TABLE_2_NM, float)
    relative = np.abs(published_curve().residuals) / table
    assert relative[-1] == pytest.approx(0.0153, abs=5e-5)
    assert relative.mean() == pytest.approx(0.0488, abs=5e-5)
    assert relative.max() == pytest.approx(0.1399, abs=5e-5)
    assert relative.argmax() == 0


def exact_aicc(powers):
    """Return AICc from a residual sum of squares in rational numbers."""
    design = [[f**k for k in powers] for f in TABLE_2_HZ]
    rss = exact_least_squares(design, TABLE_2_NM).rss
    n, k = len(TABLE_2_NM), len(powers) + 1
    return n * log(rss / n) + 2 * k + 2 * k * (k + 1) / (n - k - 1)


def test_basis_of_paper_is_not_the_best():
    points = Points(np.array(TABLE_2_HZ, float), np.array(TABLE_2_NM, float))
    curve = AiccFit(AiccSettings())(points)
    scores = [candidate.score for candidate in curve.candidates]
    assert scores == pytest.approx([-12.9, -19.7, -30.2, -9.3], abs=0.05)
    expected = [exact_aicc(powers) for powers in AiccSettings().candidates]
    assert scores == pytest.approx(expected, rel=1e-12)
    assert [candidate.chosen for candidate in curve.candidates] == [False, False, True, False]
    assert curve.formula == "T = c0 + c1·f + c4·f⁴"


@pytest.mark.parametrize("powers", [(0, 2), (0, 1, 4), (1, 2), (0, 1, 2, 3)])
def test_other_bases_equal_exact_fractions(powers):
    design = [[f**k for k in powers] for f in TABLE_2_HZ]
    exact = exact_least_squares(design, TABLE_2_NM)
    points = Points(np.array(TABLE_2_HZ, float), np.array(TABLE_2_NM, float))
    curve = BasisFit(BasisSettings(powers=powers))(points)
    assert curve.coefficients == pytest.approx([float(c) for c in exact.coefficients], rel=1e-12)
    variance = exact.rss / (len(TABLE_2_NM) - len(powers))
    expected = [[float(variance * value) for value in row] for row in exact.inverse]
    assert curve.covariance == pytest.approx(np.array(expected), rel=1e-12)
