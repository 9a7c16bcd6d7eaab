"""Accuracy of template_inverse on both rig models, against their simulated truth.

The stated limits of the product are: on the closed form, 12 seeds and 12 frequencies, an RMSE of
0.008 N·m and a greatest error of 0.02 N·m; on the time-domain rig, which shares no friction or
drive-line code with the first, 0.012 N·m and 0.02 N·m from 5 Hz to 35 Hz. The 95 % interval must
cover the truth on both without being padded.
"""

from math import sqrt

import numpy as np
import pytest

from helpers_thorough import first
from rigrunner.signal.uncertainty import coverage_factor
from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.rigrunner_bearings.compensations.helpers_sweeps import (
    FEW,
    compensate,
    errors_nm,
    sweep_of,
)

SEEDS = range(12)
SEEDS_OF_TIME = range(6)
"""Of the time-domain rig, for which no number of rigs is stated."""
NOT_SIMULATED = {"support friction under load", "gain and inertia between the runs", "load"}


def study(parameters, seeds):
    """Return (errors, compensations) of all seeds; errors in N·m of shape (seeds, points)."""
    outcomes = [compensate(sweep_of(parameters, seed=seed)) for seed in seeds]
    return np.array([errors_nm(parameters, outcome) for outcome in outcomes]), outcomes


@pytest.fixture(scope="module")
def closed_form(computed_once):
    return computed_once("template-inverse-closed-form", lambda: study(RigParameters(), SEEDS))


@pytest.fixture(scope="module")
def time_domain(computed_once):
    return computed_once(
        "template-inverse-time-domain", lambda: study(OdeParameters(), SEEDS_OF_TIME)
    )


@pytest.fixture(params=["closed_form", "time_domain"])
def either(request):
    return request.getfixturevalue(request.param)


def rmse(errors):
    return float(np.sqrt(np.mean(errors**2)))


@pytest.mark.thorough
def test_closed_form_is_within_stated_limits(closed_form):
    errors, _ = closed_form
    assert errors.shape == (12, 12)
    assert rmse(errors) <= 0.008
    assert np.abs(errors).max() <= 0.02


@pytest.mark.thorough
def test_time_domain_is_within_stated_limits(time_domain):
    errors, _ = time_domain
    from_5_hz = errors[:, 2:]
    assert rmse(from_5_hz) <= 0.012
    assert np.abs(from_5_hz).max() <= 0.02


@pytest.mark.thorough
def test_accuracy_is_half_the_stated_limits(either):
    """Half the limits: a loss of accuracy shows here before a stated limit is exceeded."""
    errors, _ = either
    assert rmse(errors) <= 0.004
    assert np.abs(errors).max() <= 0.0125


@pytest.mark.thorough
def test_torque_does_not_depend_on_frequency(either):
    """10 Hz against 35 Hz, mean of the seeds: 0.4 % for either model, apart from noise."""
    errors, _ = either
    spread = errors[:, 11] - errors[:, 4]
    noise = spread.std(ddof=1) / sqrt(len(spread))
    assert abs(spread.mean()) <= 0.004 * 0.7262 + 2 * noise


@pytest.mark.thorough
def test_interval_covers_the_truth(either):
    errors, outcomes = either
    expanded = np.array(
        [[p.torque.u * coverage_factor(p.torque.dof) for p in o.points] for o in outcomes]
    )
    assert np.mean(np.abs(errors) <= expanded) >= 0.95


@pytest.mark.thorough
def test_uncertainty_is_not_padded(either):
    """For simulated errors, stated uncertainty and observed error agree within a factor of 1.5.

    The set-points of one rig share its sensor, so each rig is one value of the mean square, and few
    rigs leave it uncertain: the factor is compared with the far end of its 90 % interval. Over 48
    rigs of the closed form the ratio is 0.76 ± 0.08, over 36 of the time domain 0.70 ± 0.07 (95 %):
    lines such as 'finite band' are limits for resonances of 200 to 800 Hz, not for 400 Hz alone.
    """
    errors, outcomes = either
    stated = np.array([[simulated_u(point) for point in outcome.points] for outcome in outcomes])
    squares = np.mean((errors / stated) ** 2, axis=1)
    t = coverage_factor(len(squares) - 1, 0.9)
    half_width = t * squares.std(ddof=1) / sqrt(len(squares))
    assert sqrt(squares.mean() + half_width) > 1 / 1.5
    assert sqrt(max(squares.mean() - half_width, 0.0)) < 1.5


@pytest.mark.thorough
def test_uncertainty_is_below_12_mnm(either):
    _, outcomes = either
    assert max(p.torque.u for o in outcomes for p in o.points) < 0.012


def simulated_u(point):
    """Return the uncertainty without errors that these rigs do not have."""
    return sqrt(sum(part.u**2 for part in point.components if part.name not in NOT_SIMULATED))


@pytest.mark.parametrize("natural_hz", first(1, [200.0, 300.0, 600.0, 800.0]))
@pytest.mark.parametrize(
    "model", first(1, [OdeParameters, RigParameters]), ids=["ode", "closed form"]
)
def test_other_resonances_are_within_limits(model, natural_hz):
    parameters = model(natural_hz=natural_hz)
    outcome = compensate(sweep_of(parameters, FEW))
    errors = errors_nm(parameters, outcome)
    assert rmse(errors) < 0.008
    assert np.abs(errors).max() < 0.02
