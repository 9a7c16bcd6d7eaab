from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import pchip_interpolate

from rigrunner.api.data import Points
from rigrunner.api.errors import DataError
from rigrunner_plugins.fits.pchip import interpolate

X = np.array([1.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0])
Y = np.array([0.83, 1.21, 1.64, 2.32, 3.01, 3.96, 5.12, 6.91])
U = np.array([0.01, 0.02, 0.01, 0.03, 0.01, 0.02, 0.05, 0.01])


def test_curve_passes_through_every_point_with_its_uncertainty():
    value, u = interpolate(Points(X, Y, U)).predict(X)
    assert value == pytest.approx(Y, rel=1e-14)
    assert u == pytest.approx(U, rel=1e-12)


def test_curve_equals_scipy_between_points_and_is_monotonic():
    x = np.linspace(1, 35, 500)
    value, _ = interpolate(Points(X, Y, U)).predict(x)
    assert value == pytest.approx(pchip_interpolate(X, Y, x), rel=1e-14)
    assert np.all(np.diff(value) > 0)


def test_uncertainty_equals_that_of_numerical_gradients():
    """Against derivatives of scipy's interpolant with steps a hundred times smaller than u."""
    x = np.array([2.0, 12.0, 33.0])
    _, u = interpolate(Points(X, Y, U)).predict(x)
    step = 1e-4
    gradient = [
        (pchip_interpolate(X, Y + step * e, x) - pchip_interpolate(X, Y - step * e, x)) / (2 * step)
        for e in np.eye(8)
    ]
    assert u == pytest.approx(np.linalg.norm(np.array(gradient).T * U, axis=1), rel=2e-3)


def test_coefficients_are_the_values_at_the_points():
    curve = interpolate(Points(X[::-1], Y[::-1], U[::-1]))
    assert curve.names[:2] == ("T(1 Hz)", "T(5 Hz)")
    assert curve.coefficients.tolist() == Y.tolist()
    assert np.diag(curve.covariance) == pytest.approx(U**2)


def test_exact_values_have_no_uncertainty():
    _, u = interpolate(Points(X, Y, np.zeros(8))).predict(np.array([12.0]))
    assert u == 0


@pytest.mark.parametrize("x", [10.0, 10.04])
def test_two_points_at_one_frequency_are_refused(x):
    points = Points(np.array([5.0, 10.0, x, 20.0]), Y[:4], U[:4])
    with pytest.raises(DataError, match=rf"two points at the same f, 10 and {x:.6g} Hz"):
        interpolate(points)


def test_different_temperatures_in_kelvin_are_different_points():
    kelvin = np.linspace(293.15, 298.15, 8)
    curve = interpolate(Points(kelvin, Y, U, x_unit="K"))
    assert curve.predict(kelvin)[0] == pytest.approx(Y)
    kelvin[1] = kelvin[0] + 0.01
    with pytest.raises(DataError, match="two points at the same f"):
        interpolate(Points(kelvin, Y, U, x_unit="K"))
