from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from rigrunner.api.data import Points
from rigrunner.api.errors import DataError
from rigrunner.signal.bands import bands
from rigrunner_plugins.fits.pchip import interpolate
from rigrunner_plugins.fits.polynomial import PolynomialFit
from rigrunner_plugins.fits.settings import PolynomialSettings

X = np.array([1.0, 5.0, 10.0, 15.0, 20.0, 30.0, 35.0])
LINE = PolynomialFit(PolynomialSettings(degree=1))


def test_a_straight_line_has_the_bands_of_the_textbook():
    """Draper and Smith: t s sqrt(1/n + (x - mean)^2 / Sxx), and with 1 + under the root."""
    y = 0.9 + 0.1 * X + np.array([0.02, -0.03, 0.01, 0.0, 0.02, -0.01, -0.01])
    curve = bands(LINE(Points(X, y)), np.array([1.0, 12.0, 35.0]))
    fitted = stats.linregress(X, y)
    residuals = y - fitted.intercept - fitted.slope * X
    s, t = np.sqrt(np.sum(residuals**2) / 5), stats.t.ppf(0.975, 5)
    leverage = 1 / 7 + (np.array([1.0, 12.0, 35.0]) - X.mean()) ** 2 / np.sum((X - X.mean()) ** 2)
    assert curve.value == pytest.approx(fitted.intercept + fitted.slope * np.array([1, 12, 35]))
    assert curve.confidence == pytest.approx(t * s * np.sqrt(leverage))
    assert curve.prediction == pytest.approx(t * s * np.sqrt(1 + leverage))


def test_one_more_point_falls_into_the_prediction_band_as_often_as_it_says():
    """Of 2000 further points 80 %: binomial 1600 +/- 3 * 17.9."""
    rng = np.random.default_rng(4)
    inside = 0
    for _ in range(2000):
        y = 0.9 + 0.1 * X + rng.normal(0, 0.05, 7)
        curve = bands(LINE(Points(X, y)), np.array([12.0]), p=0.8)
        inside += abs(0.9 + 1.2 + rng.normal(0, 0.05) - curve.value[0]) < curve.prediction[0]
    assert 1546 <= inside <= 1654


def test_nobody_knows_where_one_more_point_falls_beside_an_interpolation():
    curve = bands(interpolate(Points(X, X, np.full(7, 0.1))), X)
    assert curve.confidence == pytest.approx(np.full(7, 0.1959964))
    assert np.isnan(curve.prediction).all()


def test_outside_the_range_there_is_no_band():
    with pytest.raises(DataError, match="not at 40"):
        bands(LINE(Points(X, X)), np.array([40.0]))
