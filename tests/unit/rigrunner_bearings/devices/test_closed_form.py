"""The closed-form rig against integrals and definitions computed here."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lsim

from helpers_thorough import examples
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from rigrunner_bearings.devices.swing_tester_sim.rig import (
    peak_level_nm,
    resonate,
    steady_state,
    swing,
)
from rigrunner_bearings.signal import kinematics

RATIO = 2 / 45
DEG = np.pi / 180
N = 65_536
PHASE = 2 * np.pi * np.arange(N) / N
RIGID = RigParameters(natural_hz=1e7)


def test_drive_line_solves_equation_of_motion():
    """J u'' + c u' + k u = M for the twist u gives the shaft's torque c u' + k u."""
    natural, damping, frequency, cycles = 400.0, 0.05, 10.0, 20
    omega = 2 * np.pi * natural
    torque = np.sign(np.sin(PHASE[::16])) + np.cos(3 * PHASE[::16])
    time = np.arange(cycles * len(torque)) / (frequency * len(torque))
    system = ([2 * damping * omega, omega**2], [1, 2 * damping * omega, omega**2])
    _, settled, _ = lsim(system, np.tile(torque, cycles), time)
    shaft = resonate(torque, frequency, natural, damping)
    assert np.abs(shaft - settled[-len(torque) :]).max() < 2e-3


def test_travel_restarts_at_each_reversal():
    motion = swing(PHASE, 5.0, RATIO)
    assert motion.travel_rad.min() == pytest.approx(0, abs=1e-8)
    assert motion.travel_rad.max() == pytest.approx(2 * np.arcsin(RATIO), rel=1e-6)
    slope = np.diff(motion.travel_rad)
    assert (slope < 0).sum() == 2
    assert set(motion.sense) == {-1.0, 1.0}


def test_friction_of_previous_stroke_is_not_starting_torque():
    """A bearing with a long slip: friction of the previous stroke still acts at the reversal."""
    rig = RigParameters(kinetic_torque_nm=0.9, bearing_slip_rad=0.4 * DEG, stribeck=True)
    rig = replace(rig, starting_torque_nm=0.9)
    truth = steady_state(rig, 1000.0, 10.0).truth["starting_torque_nm"]
    assert truth == pytest.approx(0.9 * (1 - 2 * np.exp(-1 / 0.4)), abs=2e-3)


@settings(deadline=None, max_examples=examples(25))
@given(
    kinetic=st.floats(0.1, 1.0),
    excess=st.floats(0.01, 0.5),
    slip=st.floats(0.02, 0.15),
    weakening=st.floats(0.2, 2.0),
)
def test_bearing_peaks_at_starting_torque_within_one_degree(kinetic, excess, slip, weakening):
    rig = RigParameters(
        starting_torque_nm=kinetic + excess,
        kinetic_torque_nm=kinetic,
        bearing_slip_rad=slip * DEG,
        weakening_rad=weakening * DEG,
    )
    state = steady_state(rig, 1000.0, 10.0)
    assert state.truth["starting_torque_nm"] == pytest.approx(kinetic + excess, abs=2e-5)


@pytest.mark.parametrize("frequency", [1.0, 35.0])
def test_bearing_torque_is_proportional_to_load_at_any_speed(frequency):
    for load in (500.0, 2000.0):
        truth = steady_state(RigParameters(), load, frequency).truth
        assert truth["starting_torque_nm"] == pytest.approx(0.7262 * load / 1000, abs=1e-5)


def test_work_per_cycle_follows_friction_law():
    """Slip weakening and Dahl's rise integrate in closed form over each stroke."""
    rig = replace(RIGID, support_damping_nms=0.0)
    state = steady_state(rig, 1000.0, 2.0)
    angle = kinematics.swing_angle(PHASE, RATIO)
    work = np.trapezoid(np.append(state.torque_nm, state.torque_nm[0]), np.append(angle, angle[0]))
    stroke = 2 * np.arcsin(RATIO)
    support, db, ds = rig.support_slip_rad, rig.bearing_slip_rad, rig.weakening_rad
    combined = db * ds / (db + ds)
    rise = stroke - 2 * support * (1 - np.exp(-stroke / support))
    excess = peak_level_nm(rig) - 0.64
    bearing = 0.64 * (stroke - 2 * db) + excess * (ds * (1 - np.exp(-stroke / ds)) - combined)
    assert work == pytest.approx(2 * (0.7597 * rise + bearing), rel=1e-5)


def test_only_inertia_remains_without_friction():
    rig = replace(RIGID, support_friction_nm=0.0, support_damping_nms=0.0)
    torque = steady_state(rig, 0.0, 35.0).torque_nm
    assert torque.max() == pytest.approx(0.002324 * 2170.586, rel=1e-5)


def test_stribeck_starting_torque_falls_with_frequency():
    rig = RigParameters(stribeck=True)
    slow, fast = (steady_state(rig, 1000.0, f).truth["starting_torque_nm"] for f in (1.0, 35.0))
    assert slow > fast + 0.02
    assert 0.64 * (1 - 2 * np.exp(-10)) - 1e-6 <= fast < slow <= 0.7262


def test_zero_load_friction_is_not_load_induced():
    truth = steady_state(RigParameters(zero_load_torque_nm=0.1), 1000.0, 10.0).truth
    assert truth["starting_torque_nm"] == pytest.approx(0.7262, abs=1e-5)
    assert truth["bearing_torque_nm"] == pytest.approx(0.8262, abs=1e-5)


def test_inertia_change_under_load_moves_resonance():
    truth = steady_state(RigParameters(loaded_inertia_change=0.21), 1000.0, 10.0).truth
    assert truth["inertia_kgm2"] == pytest.approx(1.21 * 0.002324)
    assert truth["natural_frequency_hz"] == pytest.approx(400 / 1.1)
    unloaded = steady_state(RigParameters(loaded_inertia_change=0.21), 0.0, 10.0).truth
    assert unloaded["inertia_kgm2"] == 0.002324
