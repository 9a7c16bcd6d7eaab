"""The time-domain rig against closed forms that its friction does not use."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rigrunner.api.errors import DeviceError
from rigrunner_bearings.devices.swing_tester_ode import rig as ode
from rigrunner_bearings.devices.swing_tester_ode.elements import mechanism
from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters
from rigrunner_bearings.devices.swing_tester_ode.rig import (
    _steady_state,
    starting_torque_nm,
    steady_state,
)
from rigrunner_bearings.signal import kinematics

RATIO = 2 / 45
FREE = OdeParameters(
    support_friction_nm=0.0, viscous_nms=0.0, kinetic_torque_nm=1e-9, overshoot_nm=0.0
)


def test_frictionless_rig_is_base_excited_resonance():
    """Torque = J alpha times (1 + 2 z q)/(1 + 2 z q + q^2) harmonic by harmonic."""
    torque = steady_state(FREE, 0.0, 30.0).torque_nm
    phase = 2 * np.pi * np.arange(len(torque)) / len(torque)
    rigid = FREE.inertia_kgm2 * kinematics.angular_acceleration(phase, 30.0, RATIO)
    q = 1j * 30.0 * np.arange(len(phase) // 2 + 1) / FREE.natural_hz
    response = (1 + 2 * 0.05 * q) / (1 + 2 * 0.05 * q + q**2)
    expected = np.fft.irfft(np.fft.rfft(rigid) * response, len(phase))
    assert np.abs(torque - expected).max() < 1e-5


def test_rig_agrees_with_adaptive_solver():
    rig, frequency = OdeParameters(), 20.0
    parts = mechanism(rig, 1000.0)

    def slope(time, state):
        phase = np.array(2 * np.pi * frequency * time)
        velocity = float(kinematics.angular_velocity(phase, frequency, RATIO))
        acceleration = float(kinematics.angular_acceleration(phase, frequency, RATIO))
        return parts.derivative(tuple(state), velocity, acceleration)

    torque = steady_state(rig, 1000.0, frequency).torque_nm
    times_s = (5 + np.arange(0, len(torque), 64) / len(torque)) / frequency
    solution = solve_ivp(
        slope, (0, 6 / frequency), ode.IN_MID_STROKE, t_eval=times_s, method="DOP853",
        rtol=1e-6, atol=1e-9, max_step=1e-3,
    )  # fmt: skip
    assert np.abs(parts.shaft_torque(solution.y[0], solution.y[1]) - torque[::64]).max() < 1e-3


def test_shaft_torque_is_inertia_plus_all_frictions():
    """Newton: shaft torque = J d2(angle)/dt2 + supports + (stick - overshoot) of the bearing."""
    rig, hertz = OdeParameters(), 20.0
    states = ode.steady_cycle(mechanism(rig, 1000.0), rig.natural_hz, hertz, RATIO)
    twist, rate, support, stick, overshoot = states.T
    phase = 2 * np.pi * np.arange(len(states)) / len(states)
    order = 2j * np.pi * hertz * np.arange(len(phase) // 2 + 1)
    angle = np.fft.rfft(kinematics.swing_angle(phase, RATIO) - twist)
    speed, acceleration = (np.fft.irfft(angle * order**k, len(phase)) for k in (1, 2))
    friction = 0.805 * support + 0.27 * speed + (0.64 + 0.1568) * stick - 0.1568 * overshoot
    angular = 2 * np.pi * 400.0
    shaft = 0.00264 * (angular**2 * twist + 2 * 0.05 * angular * rate)
    assert np.abs(shaft - 0.00264 * acceleration - friction).max() < 0.01


def test_step_size_is_fine_enough(monkeypatch):
    coarse = steady_state(OdeParameters(), 1000.0, 35.0)
    monkeypatch.setattr(ode, "FEWEST_STEPS", 8192)
    fine = _steady_state.__wrapped__(OdeParameters(), 1000.0, 35.0)
    assert np.abs(fine.torque_nm[::4] - coarse.torque_nm).max() < 1e-3
    assert fine.truth["starting_torque_nm"] == pytest.approx(
        coarse.truth["starting_torque_nm"], abs=1e-5
    )


def test_friction_element_reverses_exponentially_over_its_slip():
    """Dahl 1968: after a reversal z = 1 - 2 exp(-travel/slip)."""
    rig = OdeParameters(natural_hz=2000.0, damping_ratio=0.3)
    states = ode.steady_cycle(mechanism(rig, 1000.0), rig.natural_hz, 5.0, RATIO)
    phase = 2 * np.pi * np.arange(len(states)) / len(states)
    angle = kinematics.swing_angle(phase, RATIO) - states[:, 0]
    top, bottom = int(np.argmax(angle)), int(np.argmin(angle))
    travel = angle[top] - angle[top:bottom]
    for column, slip in ((2, rig.support_slip_rad), (4, rig.overshoot_slip_rad)):
        expected = -(1 - 2 * np.exp(-travel / slip))
        assert np.abs(states[top:bottom, column] - expected).max() < 2e-3


def test_speed_weakening_bearing_follows_stribeck():
    """In the middle of a stroke, far beyond its slip: T = Tk + (Ts - Tk) exp(-|v|/vs)."""
    rig = OdeParameters(
        stribeck=True, stribeck_speed_rad_s=2.0, natural_hz=2000.0, damping_ratio=0.3
    )
    parts = mechanism(rig, 1000.0)
    states = ode.steady_cycle(parts, rig.natural_hz, 5.0, RATIO)
    velocity = float(kinematics.angular_velocity(np.array(0.0), 5.0, RATIO))
    expected = 0.64 + 0.1568 * np.exp(-velocity / 2.0)
    assert parts.bearing_torque(states[0, 3], states[0, 4]) == pytest.approx(expected, rel=1e-3)


def test_bearing_slides_at_kinetic_torque():
    parts = mechanism(OdeParameters(), 2000.0)
    assert parts.bearing_torque(np.array(1.0), np.array(1.0)) == pytest.approx(2 * 0.64)


def test_starting_torque_is_mean_of_both_directions_within_one_degree():
    angle = np.deg2rad(np.concatenate([np.linspace(-2, 2, 401), np.linspace(2, -2, 401)[1:-1]]))
    torque = np.where(np.arange(800) < 400, 0.3, -0.5)
    torque[250] = 9.0  # 2.5 deg after the reversal
    assert starting_torque_nm(angle, torque) == pytest.approx(0.4)


def test_friction_of_previous_stroke_is_not_starting_torque():
    """With Stribeck's law it is greatest just before the reversal, at rest."""
    angle = np.deg2rad(np.concatenate([np.linspace(-2, 2, 401), np.linspace(2, -2, 401)[1:-1]]))
    torque = np.where(np.arange(800) < 400, 0.3, -0.5)
    torque[395:405] = 0.9
    torque[:5] = -0.9
    torque[797:] = -0.9
    assert starting_torque_nm(angle, torque) == pytest.approx(0.4)


def test_zero_load_gives_zero_starting_torque():
    assert steady_state(OdeParameters(), 0.0, 10.0).truth["starting_torque_nm"] == 0.0


def test_rig_that_does_not_settle_is_reported(monkeypatch):
    monkeypatch.setattr(ode, "MOST_CYCLES", 2)
    with pytest.raises(DeviceError, match="does not settle at 35 Hz"):
        _steady_state.__wrapped__(replace(OdeParameters(), damping_ratio=0.01), 0.0, 35.0)
