from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from rigrunner.api.data import Points
from rigrunner.api.errors import DataError
from rigrunner_plugins.fits.polynomial import BasisFit, PolynomialFit
from rigrunner_plugins.fits.settings import BasisSettings, PolynomialSettings

X = np.array([1.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0])
Y = np.array([0.83, 1.21, 1.64, 2.32, 3.01, 3.96, 5.12, 6.91])


def fit(points, powers, **changes):
    return BasisFit(BasisSettings(powers=powers, **changes))(points)


@pytest.mark.parametrize("weighted", [False, True])
def test_all_powers_equal_the_polynomial(weighted):
    points = Points(X, Y, np.linspace(0.01, 0.1, 8))
    ours = fit(points, [2, 0, 1], weighted=weighted)
    theirs = PolynomialFit(PolynomialSettings(degree=2, weighted=weighted))(points)
    assert (ours.formula, ours.names, ours.units) == (theirs.formula, theirs.names, theirs.units)
    assert ours.coefficients == pytest.approx(theirs.coefficients, rel=1e-14)
    assert ours.covariance == pytest.approx(theirs.covariance, rel=1e-13)
    assert ours.r_squared == pytest.approx(theirs.r_squared, rel=1e-14)


def test_fit_without_an_intercept_passes_through_the_origin():
    """By hand: the slope is sum(xy)/sum(x^2) = 28/14, R² about zero 1 - 0/56."""
    curve = fit(Points(np.array([1.0, 2.0, 3.0]), np.array([2.0, 4.0, 6.0])), [1])
    assert curve.formula == "T = c1·f"
    assert curve.coefficients == pytest.approx([2.0], rel=1e-15)
    assert curve.r_squared == 1.0
    assert curve.dof == 2


def test_weighted_r_squared_is_about_the_weighted_mean():
    u_y = np.array([0.1, 0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.2])
    curve = fit(Points(X, Y, u_y), [0, 2], weighted=True)
    weights = u_y**-2.0
    total = np.sum(weights * (Y - np.average(Y, weights=weights)) ** 2)
    rss = np.sum(weights * curve.residuals**2)
    assert curve.r_squared == pytest.approx(1 - rss / total, rel=1e-12)


def test_values_that_vary_by_rounding_have_no_r_squared():
    """The mean of seven times 0.7 is not 0.7 in floats."""
    assert np.isnan(fit(Points(X[:7], np.full(7, 0.7)), [0, 1]).r_squared)


def test_formula_in_the_message_is_that_of_the_fit():
    with pytest.raises(DataError, match=r"T = c0 \+ c4·f⁴ with its .* needs 3 .* got 2"):
        fit(Points(X[:2], Y[:2]), [0, 4])


def test_points_at_zero_alone_are_too_few():
    with pytest.raises(DataError, match="got 1"):
        fit(Points(np.zeros(5), Y[:5]), [1])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({}, "Field required"),
        ({"powers": []}, "at least 1 item"),
        ({"powers": [0, 2, 2]}, "2 is listed 2 times; list it once"),
        ({"powers": [0, -1]}, "greater than or equal to 0"),
        ({"powers": [0, 9]}, "less than or equal to 8"),
        ({"powers": [0, 0.5]}, "valid integer"),
        ({"powers": [0, 2], "weighted": "maybe"}, "expected yes or no"),
    ],
)
def test_invalid_settings_are_refused(settings, message):
    with pytest.raises(ValidationError, match=message):
        BasisSettings(**settings)
