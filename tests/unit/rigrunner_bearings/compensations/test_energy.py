from dataclasses import replace

import numpy as np
import pytest

from rigrunner.signal.uncertainty import combine
from rigrunner_bearings.compensations.energy import Energy
from rigrunner_bearings.compensations.settings import EnergySettings
from rigrunner_bearings.compensations.swing import make_swing, running_torque
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.rigrunner_bearings.compensations.helpers_sweeps import FEW, sweep_of

SWING = make_swing(2 / 45, 1024)


def test_constant_friction_is_its_own_running_torque():
    torque = 0.7 * np.sign(SWING.velocity_per_hz)
    assert running_torque(SWING, torque) == pytest.approx(0.7, rel=1e-6)


def test_inertia_spring_and_offset_do_no_work():
    stored = 5 * SWING.acceleration_per_hz2 + 40 * SWING.angle_rad + 0.3
    assert running_torque(SWING, stored) == pytest.approx(0, abs=1e-9)


@pytest.fixture(scope="module")
def outcome():
    return Energy(EnergySettings())(sweep_of(RigParameters(), FEW))


def test_running_torque_is_kinetic_torque_at_every_frequency(outcome):
    """0.64 N·m kinetic, a little less as each stroke begins with the opposite sign."""
    values = np.array([point.torque.value for point in outcome.points])
    assert values == pytest.approx(np.full(len(FEW), 0.635), abs=0.01)
    assert np.ptp(values) < 0.006


def test_load_growth_affects_dry_friction_only():
    """Of a support without viscosity all of the running torque is dry, while nothing twists."""
    sweep = sweep_of(RigParameters(), FEW)
    torques = []
    for growth in (0.0, 0.02):
        stated = {"support_load_growth": growth, "support_load_dependence": 0.0}
        grown = replace(sweep, rig=sweep.rig.model_copy(update=stated))
        compensation = Energy(EnergySettings())(grown)
        torques.append([point.torque.value for point in compensation.points])
    dry = (np.array(torques[0]) - torques[1]) / 0.02
    undamped = sweep_of(replace(RigParameters(), support_damping_nms=0.0), FEW).no_load
    slowest = running_torque(SWING, np.mean(undamped[0].torque_nm, axis=0))
    assert dry == pytest.approx(np.full(len(FEW), slowest), rel=0.01)


def test_drift_of_dry_friction_is_in_uncertainty():
    """Up to 8 %, most likely none: a triangular distribution (JCGM 101, 6.4.5)."""
    sweep = sweep_of(RigParameters(), FEW)
    unstated = replace(
        sweep, rig=sweep.rig.model_copy(update={"support_load_dependence": None}), apart=True
    )
    for point in Energy(EnergySettings())(unstated).points:
        (drift,) = (part for part in point.components if part.name.startswith("drift of the"))
        (growth,) = (part for part in point.components if part.name.startswith("support"))
        assert drift.u == pytest.approx(0.08 / np.sqrt(6) * abs(growth.sensitivity))


def test_measurand_is_running_torque(outcome):
    assert "running torque" in outcome.measurand
    assert any("not the starting torque" in note for note in outcome.notes)


def test_parts_of_each_point_add_up(outcome):
    for point in outcome.points:
        assert point.raw_nm - point.rig_nm == pytest.approx(point.torque.value)
        assert (point.torque.u, point.torque.dof) == pytest.approx(combine(point.components))
        assert point.torque.u > 0
