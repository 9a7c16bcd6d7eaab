"""The time-domain rig: its steady cycle, and the truth in the state of its bearing."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DeviceError
from rigrunner_bearings.devices.simulated.parameters import SensorParameters
from rigrunner_bearings.devices.simulated.sampling import SimulatedRig, SteadyState
from rigrunner_bearings.devices.swing_tester_ode.elements import mechanism
from rigrunner_bearings.signal.kinematics import angular_acceleration, angular_velocity, swing_angle

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.devices.swing_tester_ode.elements import Mechanism, State
    from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters


STARTING_RAD = np.deg2rad(1.0)
"""How far after a reversal a torque still counts as starting torque."""


def time_domain_rig(rig: OdeParameters) -> SimulatedRig:
    """Return the rig with its measuring chain, ready to be sampled."""
    return SimulatedRig(rig.eccentric_ratio, partial(steady_state, rig), rig.sensors)


def steady_state(rig: OdeParameters, load_n: float, frequency_hz: float) -> SteadyState:
    """Return one cycle of the torque in the transducer's shaft, and what is true of it.

    Cached for any sensors, as the integration takes long and does not depend on them.
    """
    return _steady_state(replace(rig, sensors=SensorParameters()), load_n, frequency_hz)


@lru_cache(maxsize=64)
def _steady_state(rig: OdeParameters, load_n: float, frequency_hz: float) -> SteadyState:
    parts = mechanism(rig, load_n)
    states = steady_cycle(parts, rig.natural_hz, frequency_hz, rig.eccentric_ratio)
    twist, rate, _, stick, overshoot = states.T
    phase = 2 * np.pi * np.arange(len(states)) / len(states)
    load_side = swing_angle(phase, rig.eccentric_ratio) - twist
    bearing = parts.bearing_torque(stick, overshoot)
    truth = {
        "starting_torque_nm": starting_torque_nm(load_side, bearing),
        "inertia_kgm2": rig.inertia_kgm2,
        "natural_frequency_hz": rig.natural_hz,
        "damping_ratio": rig.damping_ratio,
        "frequency_hz": frequency_hz,
    }
    return SteadyState(parts.shaft_torque(twist, rate), truth)


def starting_torque_nm(angle_rad: Array, torque_nm: Array) -> float:
    """Return the greatest torque against the motion within 1 deg after a reversal.

    The mean of both directions. Both arrays hold one cycle, shape (n,). The angle is that of the
    load side; it reverses where it is greatest and where it is least, and travel counts from there.
    At a reversal friction still has the sign of the stroke before: that is not what is sought.
    """
    top, bottom = int(np.argmax(angle_rad)), int(np.argmin(angle_rad))
    backward = _first_degree(angle_rad, -torque_nm, top, bottom)
    forward = _first_degree(angle_rad, torque_nm, bottom, top)
    return (forward + backward) / 2


def _first_degree(angle: Array, torque: Array, start: int, end: int) -> float:
    """Return the greatest torque in the first degree of the stroke from start to end."""
    stroke = np.arange(start + 1, end + 1 + (len(angle) if end < start else 0)) % len(angle)
    travel = np.abs(angle[stroke] - angle[start])
    return float(torque[stroke][travel <= STARTING_RAD].max())


STEPS_PER_PERIOD = 40
"""Integration steps per period of the torsional resonance, the fastest thing that happens."""

FEWEST_STEPS = 2048
MOST_CYCLES = 200
SETTLED_NM = 1e-6
IN_MID_STROKE: State = (0.0, 0.0, 1.0, 1.0, 1.0)
"""Close to the steady state at phase 0: friction fully developed in the forward sense."""


def steady_cycle(
    mechanism: Mechanism, natural_hz: float, frequency_hz: float, ratio: float
) -> Array:
    """Return the states over one cycle of the steady motion, shape (n, 5), from phase 0.

    Fourth-order Runge-Kutta with fixed steps, cycle after cycle, until the shaft's torque differs
    by less than SETTLED_NM from that of the cycle before. Raises DeviceError if it never does.
    """
    steps = max(FEWEST_STEPS, math.ceil(STEPS_PER_PERIOD * natural_hz / frequency_hz))
    # The driven end at every half step of a cycle.
    phase = math.pi * np.arange(2 * steps + 1) / steps
    velocity = angular_velocity(phase, frequency_hz, ratio)
    acceleration = angular_acceleration(phase, frequency_hz, ratio)
    drive = list(zip(velocity.tolist(), acceleration.tolist(), strict=True))
    state, before = IN_MID_STROKE, np.full(steps, np.inf)
    for _ in range(MOST_CYCLES):
        states, state = _one_cycle(mechanism, state, drive, 1 / (frequency_hz * steps))
        torque = mechanism.shaft_torque(states[:, 0], states[:, 1])
        if np.abs(torque - before).max() < SETTLED_NM:
            return states
        before = torque
    raise DeviceError(
        f"the simulated rig does not settle at {frequency_hz:g} Hz within {MOST_CYCLES} cycles",
        hint="raise its damping ratio",
    )


def _one_cycle(
    mechanism: Mechanism, state: State, drive: list[tuple[float, float]], step_s: float
) -> tuple[Array, State]:
    """Return the states of a cycle, and that at the start of the next; by Runge and Kutta."""
    states = []
    for k in range(0, len(drive) - 1, 2):
        states.append(state)
        start, middle, end = drive[k : k + 3]
        first = mechanism.derivative(state, *start)
        second = mechanism.derivative(_along(state, first, step_s / 2), *middle)
        third = mechanism.derivative(_along(state, second, step_s / 2), *middle)
        fourth = mechanism.derivative(_along(state, third, step_s), *end)
        state = _along(_along(state, first, step_s / 6), second, step_s / 3)
        state = _along(_along(state, third, step_s / 3), fourth, step_s / 6)
    return np.array(states), state


def _along(state: State, slope: State, time_s: float) -> State:
    a, b, c, d, e = state
    va, vb, vc, vd, ve = slope
    return (
        a + time_s * va, b + time_s * vb, c + time_s * vc, d + time_s * vd, e + time_s * ve,
    )  # fmt: skip
