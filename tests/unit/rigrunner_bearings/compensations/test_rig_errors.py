"""Drawn errors of the rig change the result as stated in the budget."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner_bearings.api.validation import Drawable
from rigrunner_bearings.compensations.inverse import ModelInverse, TemplateInverse
from rigrunner_bearings.compensations.settings import InverseSettings, TemplateInverseSettings
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.rigrunner_bearings.compensations.helpers_sweeps import FEW, compensate, sweep_of

FEWEST = (1.0, 10.0, 20.0, 35.0)
"""The method cannot identify a rig from fewer frequencies."""


class Extreme:
    """A generator that draws the upper limit of one error, and nothing of the others."""

    def __init__(self, place):
        self.values = np.eye(2)[place]

    def uniform(self, _low, _high, size):
        assert size == 2
        return self.values


@pytest.fixture(scope="module")
def sweep():
    return sweep_of(RigParameters(), FEW)


@pytest.fixture(scope="module")
def outcome(sweep):
    return compensate(sweep)


def method(**settings):
    return TemplateInverse(TemplateInverseSettings.model_validate(settings))


def torque_change(sweep, place, **settings):
    """Return the effect of one error at its limit on the torques, shape (points,)."""
    sweep = replace(sweep, rig=sweep.rig.model_copy(update={"support_load_dependence": None}))
    compensation = method(**settings)
    changed = compensation.perturbation(sweep)(sweep, Extreme(place))
    return compensation.torques(changed) - compensation.torques(sweep)


@pytest.mark.parametrize(
    "compensation", [method(), ModelInverse(InverseSettings())], ids=["template", "model"]
)
def test_torques_equal_those_of_method(compensation, sweep):
    assert isinstance(compensation, Drawable)
    expected = [point.torque.value for point in compensation(sweep).points]
    assert compensation.torques(sweep) == pytest.approx(expected, abs=1e-12)


def test_every_drawn_error_has_a_budget_line(outcome, sweep):
    lines = {part.name for part in outcome.points[0].components}
    assert set(method().perturbation(sweep).covers) <= lines


def test_support_friction_under_load_moves_torque(sweep):
    """A published relation of the rig: growth by 2 % of 0.76 N·m moves the result by some 12 mN·m.

    Less than the whole growth of 15 mN·m, as friction has not built up where the torque is read.
    """
    change = torque_change(sweep, 1, support_load_dependence="2 %")
    assert change == pytest.approx(np.full(len(FEW), 0.012), abs=0.003)


@pytest.mark.thorough
@pytest.mark.parametrize("stated", [None, 0.05])
def test_drawn_support_drift_matches_its_budget_line(stated):
    """The torques scatter by the standard uncertainty of the line of the budget."""
    sweep = sweep_of(RigParameters(), FEWEST)
    update = {"support_load_dependence": None, "support_drift": stated}
    apart = replace(sweep, rig=sweep.rig.model_copy(update=update), apart=True)
    compensation = method(support_load_dependence="0 %") if stated else method()
    drawn = compensation.perturbation(apart)
    assert drawn.drift is not None
    assert drawn.drift.name in drawn.covers
    drift_only = replace(
        drawn, support=replace(drawn.support, limit=0.0), settings=no_corner(drawn.settings)
    )
    rng = np.random.default_rng(5)
    torques = [compensation.torques(drift_only(apart, rng))[0] for _ in range(60)]
    (line,) = (
        part.u for part in compensation(apart).points[0].components if part.name == drawn.drift.name
    )
    assert np.std(torques) == pytest.approx(line, rel=0.3)


def no_corner(settings):
    return settings.model_copy(update={"low_pass_tolerance": 0.0})


def test_low_pass_corner_error_reaches_method(sweep):
    settings = {"low_pass_tolerance": "2 %"}
    changed = method(**settings).perturbation(sweep)(sweep, Extreme(0))
    assert changed.instrument.low_pass.corner == pytest.approx(1020.0)
    assert sweep.instrument.low_pass.corner == 1000.0
    assert np.array_equal(changed.no_load[0].torque_nm, sweep.no_load[0].torque_nm)
