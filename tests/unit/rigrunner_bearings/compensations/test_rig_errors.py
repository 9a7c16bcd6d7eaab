"""What is put into the data by a draw is what the method finds in it."""

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
"""From fewer frequencies the method learns no rig."""


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


def moved(sweep, place, **settings):
    """Return what one error at its limit does to the torques, shape (points,)."""
    sweep = replace(sweep, rig=sweep.rig.model_copy(update={"support_load_dependence": None}))
    chosen = method(**settings)
    changed = chosen.perturbation(sweep)(sweep, Extreme(place))
    return chosen.torques(changed) - chosen.torques(sweep)


@pytest.mark.parametrize(
    "compensation", [method(), ModelInverse(InverseSettings())], ids=["template", "model"]
)
def test_torques_are_those_of_the_method(compensation, sweep):
    assert isinstance(compensation, Drawable)
    expected = [point.torque.value for point in compensation(sweep).points]
    assert compensation.torques(sweep) == pytest.approx(expected, abs=1e-12)


def test_the_budget_has_every_line_that_is_drawn(outcome, sweep):
    lines = {part.name for part in outcome.points[0].components}
    assert set(method().perturbation(sweep).covers) <= lines


def test_support_friction_under_load(sweep):
    """A published relation of the rig: growth by 2 % of 0.76 N·m moves the result by some 12 mN·m.

    Less than the whole growth of 15 mN·m, as friction has not built up where the torque is read.
    """
    change = moved(sweep, 1, support_load_dependence="2 %")
    assert change == pytest.approx(np.full(len(FEW), 0.012), abs=0.003)


@pytest.mark.thorough
@pytest.mark.parametrize("stated", [None, 0.05])
def test_drift_of_the_support_is_drawn_as_its_line_says(stated):
    """Drawn into the data it moves the torques by what the line of the budget is."""
    sweep = sweep_of(RigParameters(), FEWEST)
    update = {"support_load_dependence": None, "support_drift": stated}
    apart = replace(sweep, rig=sweep.rig.model_copy(update=update), apart=True)
    chosen = method(support_load_dependence="0 %") if stated else method()
    drawn = chosen.perturbation(apart)
    assert drawn.drift is not None
    assert drawn.drift.name in drawn.covers
    only = replace(
        drawn, support=replace(drawn.support, limit=0.0), settings=no_corner(drawn.settings)
    )
    rng = np.random.default_rng(5)
    moved = [chosen.torques(only(apart, rng))[0] for _ in range(60)]
    (line,) = (
        part.u for part in chosen(apart).points[0].components if part.name == drawn.drift.name
    )
    assert np.std(moved) == pytest.approx(line, rel=0.3)


def no_corner(settings):
    return settings.model_copy(update={"low_pass_tolerance": 0.0})


def test_low_pass_corner_is_told_to_the_method(sweep):
    wider = {"low_pass_tolerance": "2 %"}
    changed = method(**wider).perturbation(sweep)(sweep, Extreme(0))
    assert changed.instrument.low_pass.corner == pytest.approx(1020.0)
    assert sweep.instrument.low_pass.corner == 1000.0
    assert np.array_equal(changed.no_load[0].torque_nm, sweep.no_load[0].torque_nm)
