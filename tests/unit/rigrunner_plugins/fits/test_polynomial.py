from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from rigrunner.api.data import Points
from rigrunner.api.errors import DataError
from rigrunner_plugins.fits.polynomial import PolynomialFit
from rigrunner_plugins.fits.settings import PolynomialSettings

X = np.array([1.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0])
Y = np.array([0.83, 1.21, 1.64, 2.32, 3.01, 3.96, 5.12, 6.91])


def fit(points, **changes):
    return PolynomialFit(PolynomialSettings(**changes))(points)


def test_prediction_uses_the_full_covariance():
    """At 10 Hz of the paper's Table 2: 1.569065 with u 0.0710535; without covariance 0.2301."""
    curve = fit(Points(X, Y))
    value, u = curve.predict(np.array([10.0]))
    gradient = np.array([1.0, 10.0, 100.0])
    assert value == pytest.approx([gradient @ curve.coefficients], rel=1e-14)
    assert u == pytest.approx([np.sqrt(gradient @ curve.covariance @ gradient)], rel=1e-9)
    assert u == pytest.approx([0.07105352], abs=5e-9)


def test_formula_names_and_units():
    curve = fit(Points(X, Y))
    assert curve.formula == "T = c0 + c1·f + c2·f²"
    assert curve.names == ("c0", "c1", "c2")
    assert curve.units == ("N·m", "N·m/Hz", "N·m/Hz²")


def test_residuals_are_observed_minus_fitted():
    curve = fit(Points(X, Y))
    assert curve.residuals == pytest.approx(Y - np.polyval(curve.coefficients[::-1], X), abs=1e-14)


def test_weighted_fit_equals_numpy():
    u_y = np.array([0.01, 0.01, 0.02, 0.02, 0.03, 0.05, 0.1, 0.2])
    curve = fit(Points(X, Y, u_y), weighted=True)
    expected, covariance = np.polyfit(X, Y, 2, w=1 / u_y, cov=True)
    assert curve.coefficients[::-1] == pytest.approx(expected, rel=1e-10)
    assert curve.covariance[::-1, ::-1] == pytest.approx(covariance, rel=1e-8)
    residuals = Y - np.polyval(expected, X)
    assert curve.residuals == pytest.approx(residuals, abs=1e-12)
    weights = u_y**-2 / np.mean(u_y**-2)
    assert curve.residual_s == pytest.approx(np.sqrt(np.sum(weights * residuals**2) / 5))


def test_equal_weights_equal_no_weights():
    weighted, plain = fit(Points(X, Y, np.full(8, 0.02)), weighted=True), fit(Points(X, Y))
    assert weighted.coefficients == pytest.approx(plain.coefficients, rel=1e-13)
    assert weighted.residual_s == pytest.approx(plain.residual_s, rel=1e-13)
    assert weighted.r_squared == pytest.approx(plain.r_squared, rel=1e-13)


@pytest.mark.parametrize("u_y", [None, np.zeros(8)])
def test_weights_need_uncertainties(u_y):
    with pytest.raises(DataError, match="uncertainty of every point"):
        fit(Points(X, Y, u_y), weighted=True)


def test_prediction_outside_the_points_is_refused():
    curve = fit(Points(X, Y))
    assert curve.valid_x == (1.0, 35.0)
    with pytest.raises(DataError, match="holds from 1 to 35, not at 36"):
        curve.predict(np.array([10.0, 36.0]))
    with pytest.raises(DataError, match=r"not at 0\.9"):
        curve.predict(np.array([0.9]))


def test_prediction_half_a_percent_outside_is_permitted():
    value, _ = fit(Points(X, Y)).predict(np.array([0.996, 35.1]))
    assert value == pytest.approx([0.9459, 6.774], abs=2e-3)


def test_too_few_different_frequencies_are_refused():
    repeated = Points(np.array([1.0, 1.0, 5.0, 5.0, 10.0, 10.0]), np.arange(6.0))
    with pytest.raises(DataError, match="needs 4 different values of f, got 3"):
        fit(repeated)


def test_constant_points_have_no_r_squared():
    curve = fit(Points(X, np.full(8, 2.5)), degree=1)
    assert curve.coefficients == pytest.approx([2.5, 0.0], abs=1e-15)
    assert np.isnan(curve.r_squared)


@pytest.mark.parametrize("settings", [{"degree": 0}, {"degree": 11}, {"degree": 2.0}, {"order": 2}])
def test_invalid_settings_are_refused(settings):
    with pytest.raises(ValidationError):
        PolynomialSettings(**settings)


def test_tolerance_outside_is_a_share_of_the_range_for_temperatures():
    """From 20 °C to 25 °C half a per cent of 298 K would be 1.5 K, three tenths of the range."""
    kelvin = np.linspace(293.15, 298.15, 8)
    curve = fit(Points(kelvin, Y, x_unit="K"), degree=1)
    curve.predict(np.array([293.0, 298.3]))
    for outside in (291.8, 299.5):
        with pytest.raises(DataError, match="not at"):
            curve.predict(np.array([outside]))
