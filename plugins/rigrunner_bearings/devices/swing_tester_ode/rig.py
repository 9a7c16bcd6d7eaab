"""The time-domain rig: its steady cycle, and the truth in the state of its bearing."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.devices.simulated.parameters import SensorParameters
from rigrunner_bearings.devices.simulated.sampling import SimulatedRig, SteadyState
from rigrunner_bearings.devices.swing_tester_ode.elements import mechanism
from rigrunner_bearings.devices.swing_tester_ode.integrate import steady_cycle
from rigrunner_bearings.signal.kinematics import swing_angle

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters

STARTING_RAD = np.deg2rad(1.0)
"""How far after a reversal a torque still counts as starting torque."""


def time_domain_rig(rig: OdeParameters) -> SimulatedRig:
    """Return the rig with its measuring chain, ready to be sampled."""
    return SimulatedRig(rig.eccentric_ratio, partial(steady_state, rig), rig.sensors)


def steady_state(rig: OdeParameters, load_n: float, frequency_hz: float) -> SteadyState:
    """Return one cycle of the torque in the transducer's shaft, and what is true of it.

    Remembered, whatever the sensors are, as the integration takes long and knows none of them.
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
