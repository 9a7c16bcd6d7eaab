"""The full covariance of a fit: Eq. (2) of the paper at 10 Hz with its uncertainty.

Wang et al., Machines 2025, 13(11), 976: Td = Tc - (c0 + c1 f + c2 f^2), c by ordinary least squares
of Table 2. Tc as of Table 1, with u = 0.01 N·m of 10 readings, and a sensor of 20 N·m within
0.5 % of full scale. u(Td) is 0.092 N·m; it would be 0.238 N·m without the covariances.
"""

from math import inf, sqrt

import numpy as np
import pytest

from rigrunner.api.data import Points
from rigrunner.api.uncertainty import Distribution, Input, MeasurementModel
from rigrunner.signal.monte_carlo.adaptive import Adaptive
from rigrunner.signal.monte_carlo.adaptive import propagate as by_trials
from rigrunner.signal.monte_carlo.model import output_of
from rigrunner.signal.propagation import propagate
from rigrunner.signal.uncertainty import coverage_factor
from rigrunner_bearings.compensations.paper_peak import TABLE_2_HZ, TABLE_2_NM
from rigrunner_plugins.fits.polynomial import PolynomialFit
from rigrunner_plugins.fits.settings import PolynomialSettings

HZ = 10.0
NAMES = ("c0", "c1", "c2")
FIT = PolynomialFit(PolynomialSettings(degree=2))(
    Points(np.array(TABLE_2_HZ), np.array(TABLE_2_NM))
)


def model(*, with_covariance=True):
    u = np.sqrt(np.diag(FIT.covariance))
    fit = tuple(
        Input(name, value, u_value, FIT.dof, line="no-load fit", ensemble="fit")
        for name, value, u_value in zip(NAMES, FIT.coefficients, u, strict=True)
    )
    inputs = (
        Input("peak", 2.16, 0.01, 9, Distribution.T),
        Input("sensor", 0.0, 0.005 * 20 / sqrt(3), inf, Distribution.RECTANGULAR),
        *fit,
    )
    correlation = np.eye(5)
    if with_covariance:
        correlation[2:, 2:] = FIT.covariance / np.outer(u, u)

    def equation(x):
        rig = x["c0"] + x["c1"] * HZ + x["c2"] * HZ**2
        return x["peak"] + x["sensor"] - rig

    return MeasurementModel(inputs, equation, correlation)


def test_uncertainty_with_full_covariance():
    result = propagate(model())
    assert result.estimate.value == pytest.approx(0.590935, abs=5e-7)
    assert result.estimate.u == pytest.approx(0.0920974, abs=5e-8)
    assert result.estimate.dof == pytest.approx(14.11, abs=0.005)
    assert coverage_factor(result.estimate.dof) == pytest.approx(2.1432, abs=5e-5)


def test_fit_is_one_budget_line():
    result = propagate(model())
    assert [part.name for part in result.components] == ["peak", "sensor", "no-load fit"]
    assert sum(part.u**2 for part in result.components) == pytest.approx(result.estimate.u**2)
    fit = result.components[-1]
    assert fit.dof == pytest.approx(5)
    assert fit.u == pytest.approx(sqrt(0.0920974**2 - 0.01**2 - 0.1**2 / 3), abs=1e-7)


def test_uncertainty_without_covariance_is_2_6_times_too_large():
    result = propagate(model(with_covariance=False))
    assert result.estimate.u == pytest.approx(0.2378, abs=5e-5)


def test_monte_carlo_of_full_covariance():
    """As a multivariate t of 5 degrees of freedom the fit is wider than its scale.

    u is sqrt(0.01^2 9/7 + 0.1^2/3 + u_fit^2 5/3) = 0.1090 N·m, 95 % in [0.379, 0.803] N·m.
    """
    trials = by_trials(output_of(model()), Adaptive())
    assert trials.u == pytest.approx(0.1090, abs=3e-4)
    assert trials.symmetric.low == pytest.approx(0.379, abs=1e-3)
    assert trials.symmetric.high == pytest.approx(0.803, abs=1e-3)
    assert trials.trials >= 1_000_000
