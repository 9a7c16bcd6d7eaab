"""The effect that a check states against that of the fault: the same rig with and without it."""

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


def shifts_nm(compensation, sound):
    pairs = zip(compensation.points, sound.points, strict=True)
    return np.array([one.torque.value - other.torque.value for one, other in pairs])


def with_gain(points, gain):
    return tuple(replace(point, torque_nm=(1 + gain) * point.torque_nm) for point in points)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("loaded", "residual_nm"),
    [
        pytest.param(
            lambda: runs_of(replace(SOUND, loaded_inertia_change=0.02)), 0.025, id="inertia"
        ),
        pytest.param(lambda: with_gain(runs_of(SOUND), 0.02), 0.06, id="gain"),
    ],
)
def test_change_of_inertia_or_gain_between_runs_is_removed(loaded, residual_nm, sound):
    """2 % of the inertia's torque at 35 Hz is 100 mN·m; of the friction of both, 30 to 50 mN·m.

    The runs do not show which of the two changed: the inertia's torque is removed. The effect of
    the changed resonance remains, 20 mN·m.
    """
    changed = compensated_with(loaded())
    shifts = np.abs(shifts_nm(changed, sound))
    assert shifts.max() < residual_nm
    assert all(
        shift < 1.1 * expanded(p.torque) for shift, p in zip(shifts, changed.points, strict=True)
    )
    assert changed.parameters["change of the inertia"].value == pytest.approx(0.02, abs=0.001)
    assert check_of(changed, "inertia of both runs").ok, "all of it was removed"


def test_sound_rig_fails_no_check(sound):
    _, checks = bind(sound, sound.checks)
    assert [check.name for check in checks if not check.ok] == []
