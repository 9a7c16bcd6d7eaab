"""Accuracy of model_inverse on both rig models, also at frequencies left out of the sweep.

Stated limits of the product: on the closed form, 12 seeds and 12 frequencies, an RMSE of 0.006 N·m;
on the time-domain rig J within 2 %, fn within 3 %, and an error of at most 0.02 N·m.
"""

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner.signal.uncertainty import coverage_factor
from rigrunner_bearings.compensations.inverse import ModelInverse
from rigrunner_bearings.compensations.settings import InverseSettings
from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.rigrunner_bearings.compensations.helpers_sweeps import errors_nm, sweep_of

pytestmark = pytest.mark.thorough

SEEDS = range(12)
BOTH_ENDS = (0, 2, 4, 6, 8, 11)
"""Six of the twelve frequencies, with the lowest and the highest."""


def compensate(sweep):
    return ModelInverse(InverseSettings())(sweep)


def with_few(sweep):
    return replace(sweep, no_load=tuple(sweep.no_load[i] for i in BOTH_ENDS))


def study(parameters, seeds, change=lambda sweep: sweep):
    outcomes = [compensate(change(sweep_of(parameters, seed=seed))) for seed in seeds]
    return np.array([errors_nm(parameters, outcome) for outcome in outcomes]), outcomes


@pytest.fixture(scope="module")
def closed_form(computed_once):
    return computed_once("model-inverse-closed-form", lambda: study(RigParameters(), SEEDS))


@pytest.fixture(scope="module")
def time_domain(computed_once):
    return computed_once("model-inverse-time-domain", lambda: study(OdeParameters(), range(4)))


def rmse(errors):
    return float(np.sqrt(np.mean(errors**2)))


def test_closed_form_is_within_stated_limits(closed_form):
    errors, _ = closed_form
    assert errors.shape == (12, 12)
    assert rmse(errors) <= 0.006


def test_time_domain_is_within_stated_limits(time_domain):
    errors, outcomes = time_domain
    assert np.abs(errors).max() <= 0.02
    for outcome in outcomes:
        inertia = outcome.parameters["inertia"].value
        assert inertia == pytest.approx(OdeParameters().inertia_kgm2, rel=0.02)
        natural_hz = outcome.parameters["natural frequency"].value
        assert natural_hz == pytest.approx(OdeParameters().natural_hz, rel=0.03)


@pytest.mark.parametrize("parameters", [RigParameters(), OdeParameters()], ids=["closed", "ode"])
def test_frequencies_left_out_of_sweep_are_within_limits(parameters):
    errors, _ = study(parameters, range(3), with_few)
    assert errors.shape == (3, 12)
    assert rmse(errors) <= 0.006
    assert np.abs(errors).max() <= 0.02


def test_interval_covers_the_truth(closed_form, time_domain):
    for errors, outcomes in (closed_form, time_domain):
        expanded = np.array(
            [[p.torque.u * coverage_factor(p.torque.dof) for p in o.points] for o in outcomes]
        )
        assert np.mean(np.abs(errors) <= expanded) >= 0.95


def test_frequency_outside_sweep_is_refused():
    sweep = sweep_of(RigParameters(), seed=0)
    with pytest.raises(DataError, match=r"35 Hz is outside of the no-load sweep, 1 Hz to 33 Hz"):
        compensate(replace(sweep, no_load=sweep.no_load[:-1]))
