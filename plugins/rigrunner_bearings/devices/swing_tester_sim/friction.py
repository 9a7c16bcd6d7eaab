"""Friction after a reversal, as a function of travel since it and of speed.

Both laws rise exponentially from the old sign to the new one over a slip length, as Dahl's model
does for a constant direction (Dahl, The Aerospace Corporation TOR-0158(3107-18)-1, 1968). The
bearing then weakens from its peak to its kinetic torque, with slip or with speed (Stribeck).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.signal.kinematics import angular_velocity, max_angle, swing_angle

if TYPE_CHECKING:
    from rigrunner.api import Array, Mask
    from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters

REFERENCE_LOAD_N = 1000.0
STARTING_RAD = np.deg2rad(1.0)
"""How far after a reversal a torque still counts as starting torque."""

SOLVER_POINTS = 100_000


@dataclass(frozen=True, eq=False)
class Swing:
    """A cycle as friction sees it; all of shape (n,)."""

    sense: Array
    """+1 in the forward stroke, -1 in the return."""
    speed_rad_s: Array
    travel_rad: Array
    """Angle since the last reversal."""

    @property
    def starting(self) -> Mask:
        """Where a stroke has only just begun."""
        started: Mask = (self.travel_rad > 0) & (self.travel_rad <= STARTING_RAD)
        return started


def swing(phase_rad: Array, frequency_hz: float, ratio: float) -> Swing:
    """Return the swing at crank phases of shape (n,)."""
    velocity = angular_velocity(phase_rad, frequency_hz, ratio)
    sense = np.where(velocity >= 0, 1.0, -1.0)
    travel = max_angle(ratio) + sense * swing_angle(phase_rad, ratio)
    return Swing(sense, np.abs(velocity), travel)


def support_torque(rig: RigParameters, motion: Swing, load_n: float) -> Array:
    """Return the friction of spindle and supports in N·m, shape (n,)."""
    growth = 1 + rig.support_growth_per_kn * load_n / REFERENCE_LOAD_N
    size = rig.support_friction_nm * growth + rig.support_damping_nms * motion.speed_rad_s
    slipping: Array = 1 - 2 * np.exp(-motion.travel_rad / rig.support_slip_rad)
    return size * motion.sense * slipping


def bearing_torque(rig: RigParameters, motion: Swing) -> Array:
    """Return the bearing's friction at the reference load in N·m, shape (n,)."""
    adhering: Array = np.exp(-motion.travel_rad / rig.bearing_slip_rad)
    sliding = _stribeck(rig, motion) if rig.stribeck else _slip_weakening(rig, motion)
    return motion.sense * (sliding * (1 - adhering) - rig.kinetic_torque_nm * adhering)


def starting_torque_nm(torque_nm: Array, motion: Swing) -> float:
    """Return the greatest torque against the motion within 1 deg after a reversal.

    The mean of both directions. At a reversal friction still has the sign of the stroke before:
    that is not what is sought.
    """
    forward = motion.starting & (motion.sense > 0)
    backward = motion.starting & (motion.sense < 0)
    return float((torque_nm[forward].max() - torque_nm[backward].min()) / 2)


def peak_level_nm(rig: RigParameters) -> float:
    """Return the sliding torque Tp at zero slip for which the friction just peaks at Ts.

    The friction is a(d) + (Tp - Tk) b(d) with b > 0, so it stays below Ts everywhere in (0, 1 deg]
    and touches it if Tp - Tk is the least of (Ts - a)/b.
    """
    travel = np.linspace(0, STARTING_RAD, SOLVER_POINTS + 1)[1:]
    adhering = np.exp(-travel / rig.bearing_slip_rad)
    kinetic = rig.kinetic_torque_nm * (1 - 2 * adhering)
    excess = np.exp(-travel / rig.weakening_rad) * (1 - adhering)
    return rig.kinetic_torque_nm + float(((rig.starting_torque_nm - kinetic) / excess).min())


def _slip_weakening(rig: RigParameters, motion: Swing) -> Array:
    excess = peak_level_nm(rig) - rig.kinetic_torque_nm
    return rig.kinetic_torque_nm + excess * np.exp(-motion.travel_rad / rig.weakening_rad)


def _stribeck(rig: RigParameters, motion: Swing) -> Array:
    excess = rig.starting_torque_nm - rig.kinetic_torque_nm
    return rig.kinetic_torque_nm + excess * np.exp(-motion.speed_rad_s / rig.stribeck_speed_rad_s)
