from __future__ import annotations

import numpy as np
import pytest

from rigrunner.api.data import Points
from rigrunner.api.errors import DataError
from rigrunner_bearings.fits.inertia_physical import InertiaPhysicalFit
from rigrunner_bearings.fits.settings import InertiaPhysicalSettings
from rigrunner_bearings.signal.kinematics import angular_acceleration, angular_velocity

RATIO = 2 / 45
FREQUENCIES = np.array([1.0, 3.0, 5.0, 8.0, 10.0, 15.0, 18.0, 20.0, 25.0, 30.0, 33.0, 35.0])
TRUE = (0.76, 0.31, 0.00233)
FIT = InertiaPhysicalFit(InertiaPhysicalSettings())


def peaks(support, damping, inertia, frequencies=FREQUENCIES, ratio=RATIO):
    """Return the maximum of T0 + b omega + J alpha over the forward stroke, by brute force."""
    phase = np.linspace(-np.pi, np.pi, 200_001)
    result = []
    for frequency in frequencies:
        omega = angular_velocity(phase, frequency, ratio)
        torque = support + damping * omega + inertia * angular_acceleration(phase, frequency, ratio)
        result.append(torque[omega >= 0].max())
    return np.array(result)


@pytest.mark.parametrize("true", [TRUE, (0.1, 0.05, 0.004), (1.0, 0.6, 0.001)])
def test_fit_recovers_parameters_of_its_own_model(true):
    curve = FIT(Points(FREQUENCIES, peaks(*true)))
    assert curve.coefficients == pytest.approx(true, rel=1e-4)  # the brute force has steps
    assert curve.residual_s < 1e-6
    assert curve.names == ("T0", "b", "J'")
    assert curve.units == ("N·m", "N·m·s/rad", "kg·m²")


def test_fit_predicts_between_points():
    curve = FIT(Points(FREQUENCIES, peaks(*TRUE)))
    value, _ = curve.predict(np.array([12.5, 28.0]))
    assert value == pytest.approx(peaks(*TRUE, frequencies=[12.5, 28.0]), rel=1e-6)


def test_uncertainty_matches_the_scatter_of_repeated_fits():
    """Standard deviations over 300 noisy repetitions against the stated ones, within 15 %."""
    rng = np.random.default_rng(1)
    clean = peaks(*TRUE)
    curves = [FIT(Points(FREQUENCIES, clean + rng.normal(0, 0.01, 12))) for _ in range(300)]
    scatter = np.array([curve.coefficients for curve in curves]).std(axis=0, ddof=1)
    stated = np.sqrt(np.mean([np.diag(curve.covariance) for curve in curves], axis=0))
    assert stated == pytest.approx(scatter, rel=0.15)
    predicted = np.array([curve.predict(np.array([12.0])) for curve in curves])[:, :, 0]
    u_mean = np.sqrt(np.mean(predicted[:, 1] ** 2))
    assert u_mean == pytest.approx(predicted[:, 0].std(ddof=1), rel=0.15)


def test_geometry_comes_from_the_settings():
    geometry = InertiaPhysicalSettings(eccentric="3 mm", centre_distance="60 mm")
    curve = InertiaPhysicalFit(geometry)(Points(FREQUENCIES, peaks(*TRUE, ratio=0.05)))
    assert curve.coefficients == pytest.approx(TRUE, rel=1e-6)


@pytest.mark.parametrize(
    "peaks_nm",
    [
        peaks(0.8, 0.0, 0.002),
        0.8 + 0.0035 * FREQUENCIES**2 - 0.05 * FREQUENCIES,
        2 - 0.003 * FREQUENCIES**2,
        2 - 0.02 * FREQUENCIES,
    ],
    ids=["no damping", "negative damping", "negative inertia", "falling"],
)
def test_peaks_outside_model_are_refused(peaks_nm):
    with pytest.raises(DataError, match="physical fit"):
        FIT(Points(FREQUENCIES, peaks_nm))


def test_three_points_are_too_few():
    with pytest.raises(DataError, match="3 points cannot give 3 coefficients"):
        FIT(Points(FREQUENCIES[:3], peaks(*TRUE)[:3]))
