"""GUM (JCGM 100:2008) H.3: calibration of a thermometer by a straight line."""

from __future__ import annotations

import numpy as np
import pytest

from rigrunner.api.data import Points
from rigrunner_plugins.fits.polynomial import PolynomialFit
from rigrunner_plugins.fits.settings import PolynomialSettings

T0 = 20.0
READING = [
    21.521, 22.012, 22.512, 23.003, 23.507, 23.999, 24.513, 25.002, 25.503, 26.010, 26.511,
]  # fmt: skip
CORRECTION = [
    -0.171, -0.169, -0.166, -0.159, -0.164, -0.165, -0.156, -0.157, -0.159, -0.161, -0.160,
]  # fmt: skip


@pytest.fixture
def line():
    points = Points(np.array(READING) - T0, np.array(CORRECTION), x_unit="°C", y_unit="°C")
    return PolynomialFit(PolynomialSettings(degree=1))(points)


def test_line(line):
    u = np.sqrt(np.diag(line.covariance))
    assert line.coefficients == pytest.approx([-0.1712037901313500, 0.0021826977398873], rel=1e-12)
    assert u == pytest.approx([0.0028775978351600, 0.0006679387732278], rel=1e-12)
    assert line.covariance[0, 1] / u.prod() == pytest.approx(-0.9304296030934, abs=1e-12)
    assert line.residual_s == pytest.approx(0.003497563963505, rel=1e-12)
    assert line.dof == 9


def test_correction_at_30_degrees_lies_outside_the_calibrated_range(line):
    """The GUM extrapolates; a curve of ours refuses to, so its parts are combined here."""
    value, spread = line.value_and_spread(np.array([30.0 - T0]))
    assert value[0] == pytest.approx(-0.1493768127, abs=5e-11)
    assert np.linalg.norm(spread) == pytest.approx(0.0041385958, abs=5e-11)
