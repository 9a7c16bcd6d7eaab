"""Runs the mechanism until its motion repeats, and returns that one cycle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DeviceError
from rigrunner_bearings.signal.kinematics import angular_acceleration, angular_velocity

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.devices.swing_tester_ode.elements import Mechanism, State

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
    drive = _drive(steps, frequency_hz, ratio)
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


def _drive(steps: int, frequency_hz: float, ratio: float) -> list[tuple[float, float]]:
    """Return velocity and acceleration of the driven end at every half step of a cycle."""
    phase = math.pi * np.arange(2 * steps + 1) / steps
    velocity = angular_velocity(phase, frequency_hz, ratio)
    acceleration = angular_acceleration(phase, frequency_hz, ratio)
    return list(zip(velocity.tolist(), acceleration.tolist(), strict=True))


def _one_cycle(
    mechanism: Mechanism, state: State, drive: list[tuple[float, float]], step_s: float
) -> tuple[Array, State]:
    """Return the states of a cycle, and that at the start of the next."""
    states = []
    for k in range(0, len(drive) - 1, 2):
        states.append(state)
        state = _step(mechanism, state, drive[k : k + 3], step_s)
    return np.array(states), state


def _step(
    mechanism: Mechanism, state: State, drive: list[tuple[float, float]], step_s: float
) -> State:
    start, middle, end = drive
    first = mechanism.derivative(state, *start)
    second = mechanism.derivative(_along(state, first, step_s / 2), *middle)
    third = mechanism.derivative(_along(state, second, step_s / 2), *middle)
    fourth = mechanism.derivative(_along(state, third, step_s), *end)
    state = _along(_along(state, first, step_s / 6), second, step_s / 3)
    return _along(_along(state, third, step_s / 3), fourth, step_s / 6)


def _along(state: State, slope: State, time_s: float) -> State:
    a, b, c, d, e = state
    va, vb, vc, vd, ve = slope
    return (
        a + time_s * va, b + time_s * vb, c + time_s * vc, d + time_s * vd, e + time_s * ve,
    )  # fmt: skip
