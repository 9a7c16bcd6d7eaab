"""What a check says that it moves, against what the fault did: the same rig without it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from helpers_rigs import INSTRUMENT
from helpers_rigs import RIG as DESCRIBED
from helpers_sweeps import compensate, no_fit, prepared
from rigrunner.analysis.binding import bind
from rigrunner.api.analysis import Consequence, Sweep
from rigrunner_plugins.devices.swing_tester_sim.parameters import RigParameters

FREQUENCIES = (1.0, 5.0, 8.0, 10.0, 15.0, 20.0, 25.0, 28.0, 32.0, 35.0)
SOUND = RigParameters()


def found(loaded):
    no_load = prepared(SOUND, 0.0, FREQUENCIES, seed=1)
    return compensate(Sweep(loaded, no_load, DESCRIBED, INSTRUMENT, no_fit))


def runs_of(parameters):
    return prepared(parameters, 1000.0, FREQUENCIES, seed=1)


@pytest.fixture(scope="module")
def sound():
    return found(runs_of(SOUND))


def check_of(compensation, name):
    return next(each for each in compensation.checks if each.name == name)


def moved(compensation, sound):
    pairs = zip(compensation.points, sound.points, strict=True)
    return np.array([one.torque.value - other.torque.value for one, other in pairs])


def with_gain(points, gain):
    return tuple(replace(each, torque_nm=(1 + gain) * each.torque_nm) for each in points)


@pytest.mark.parametrize(
    "loaded",
    [
        pytest.param(runs_of(replace(SOUND, loaded_inertia_change=0.02)), id="inertia"),
        pytest.param(with_gain(runs_of(SOUND), 0.02), id="gain"),
    ],
)
def test_inertia_and_gain_of_one_run_alone_move_what_the_check_says(loaded, sound):
    changed = found(loaded)
    check = check_of(changed, "inertia of both runs")
    assert not check.ok
    said = np.array([each.value for each in check.biases])
    u = np.array([each.u for each in check.biases])
    did = moved(changed, sound)
    assert np.all(np.abs(said - did)[4:] < 2 * u[4:])
    assert said[-1] == pytest.approx(did[-1], rel=0.4), "the mean of both explanations"


def test_what_the_check_says_covers_the_error(sound):
    changed = found(runs_of(replace(SOUND, loaded_inertia_change=0.01)))
    bound, checks = bind(changed, changed.checks)
    (check,) = (each for each in checks if each.name == "inertia of both runs")
    assert check.consequence is Consequence.BUDGET
    wrong = np.abs(moved(changed, sound))
    u = [part.u for point in bound.points for part in point.components if part.name == check.name]
    assert np.all(wrong[4:] < 2 * np.array(u)[4:])


def test_a_sound_rig_has_none_of_it(sound):
    _, checks = bind(sound, sound.checks)
    assert [each.name for each in checks if not each.ok] == []
