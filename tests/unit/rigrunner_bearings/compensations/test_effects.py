"""What a check says that it moves, against what the fault did: the same rig without it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from helpers_rigs import INSTRUMENT
from helpers_rigs import RIG as DESCRIBED
from rigrunner.signal.coverage import expanded
from rigrunner_bearings.api.compensations import Sweep
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from rigrunner_bearings.torque.binding import bind
from unit.rigrunner_bearings.compensations.helpers_sweeps import compensate, no_fit, prepared

FREQUENCIES = (1.0, 5.0, 8.0, 10.0, 15.0, 20.0, 25.0, 28.0, 32.0, 35.0)
SOUND = RigParameters()


def compensated_with(loaded):
    no_load = prepared(SOUND, 0.0, FREQUENCIES, seed=1)
    return compensate(Sweep(loaded, no_load, DESCRIBED, INSTRUMENT, no_fit))


def runs_of(parameters):
    return prepared(parameters, 1000.0, FREQUENCIES, seed=1)


@pytest.fixture(scope="module")
def sound():
    return compensated_with(runs_of(SOUND))


def check_of(compensation, name):
    return next(check for check in compensation.checks if check.name == name)


def moved(compensation, sound):
    pairs = zip(compensation.points, sound.points, strict=True)
    return np.array([one.torque.value - other.torque.value for one, other in pairs])


def with_gain(points, gain):
    return tuple(replace(point, torque_nm=(1 + gain) * point.torque_nm) for point in points)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("loaded", "left_nm"),
    [
        pytest.param(
            lambda: runs_of(replace(SOUND, loaded_inertia_change=0.02)), 0.025, id="inertia"
        ),
        pytest.param(lambda: with_gain(runs_of(SOUND), 0.02), 0.06, id="gain"),
    ],
)
def test_inertia_and_gain_of_one_run_alone_are_taken_out_and_the_rest_is_in_u(
    loaded, left_nm, sound
):
    """2 % of the inertia's torque at 35 Hz is 100 mN·m; of the friction of both, 30 to 50 mN·m.

    Which of the two changed the runs do not show: the inertia's torque is taken out. That another
    inertia has another resonance is left, 20 mN·m.
    """
    changed = compensated_with(loaded())
    did = np.abs(moved(changed, sound))
    assert did.max() < left_nm
    assert all(
        shift < 1.1 * expanded(p.torque) for shift, p in zip(did, changed.points, strict=True)
    )
    assert changed.parameters["change of the inertia"].value == pytest.approx(0.02, abs=0.001)
    assert check_of(changed, "inertia of both runs").ok, "nothing of it is left"


def test_a_sound_rig_has_none_of_it(sound):
    _, checks = bind(sound, sound.checks)
    assert [check.name for check in checks if not check.ok] == []
