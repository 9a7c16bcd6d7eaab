"""The closed-form rig: inertia, support and bearing, seen through the elastic drive line.

Friction is that of the rigid motion, so that one cycle of the periodic steady state follows from
the crank phase alone; the drive line then acts on the harmonics of the cycle.

Friction is a function of the travel since the last reversal, and of speed. It rises exponentially
from the old sign to the new one over a slip length, as Dahl's model does for a constant direction
(Dahl, The Aerospace Corporation TOR-0158(3107-18)-1, 1968). The bearing then weakens from its peak
to its kinetic torque, with slip or with speed (Stribeck).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.devices.simulated.sampling import GRID, SimulatedRig, SteadyState
from rigrunner_bearings.signal.kinematics import (
    angular_acceleration,
    angular_velocity,
    max_angle,
    swing_angle,
)

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
    if rig.stribeck:
        excess = rig.starting_torque_nm - rig.kinetic_torque_nm
        weakening = np.exp(-motion.speed_rad_s / rig.stribeck_speed_rad_s)
    else:
        excess = peak_level_nm(rig) - rig.kinetic_torque_nm
        weakening = np.exp(-motion.travel_rad / rig.weakening_rad)
    sliding = rig.kinetic_torque_nm + excess * weakening
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


def resonate(
    torque_nm: Array, frequency_hz: float, natural_hz: float, damping_ratio: float
) -> Array:
    """Return what the shaft carries of a periodic torque on the mass; one cycle, shape (n,).

    The shaft is driven at one end, so torque passes as force does in base excitation:
    (1 + 2 z q)/(1 + 2 z q + q^2) with q = j f/fn (Den Hartog, Mechanical Vibrations, ch. 2).
    """
    spectrum = np.fft.rfft(torque_nm)
    q = 1j * frequency_hz * np.arange(len(spectrum)) / natural_hz
    elastic = 1 + 2 * damping_ratio * q
    return np.fft.irfft(spectrum * elastic / (elastic + q**2), len(torque_nm))


def closed_form_rig(rig: RigParameters) -> SimulatedRig:
    """Return the rig with its measuring chain, ready to be sampled."""
    return SimulatedRig(rig.eccentric_ratio, partial(steady_state, rig), rig.sensors)


@lru_cache(maxsize=64)
def steady_state(rig: RigParameters, load_n: float, frequency_hz: float) -> SteadyState:
    """Return one cycle of the torque in the transducer's shaft, and what is true of it.

    Cached, as a stream needs it twice, and a repeated one again; it has no noise.
    """
    phase = 2 * np.pi * np.arange(GRID) / GRID
    motion = swing(phase, frequency_hz, rig.eccentric_ratio)
    # The bearing's torque that load induces, and that which it has without load.
    reference = bearing_torque(rig, motion)
    loaded = reference * (load_n / REFERENCE_LOAD_N)
    unloaded = reference * (rig.zero_load_torque_nm / rig.starting_torque_nm)
    inertia_kgm2 = rig.inertia_kgm2 * (1 + (rig.loaded_inertia_change if load_n > 0 else 0.0))
    torque = inertia_kgm2 * angular_acceleration(phase, frequency_hz, rig.eccentric_ratio)
    torque = torque + support_torque(rig, motion, load_n) + loaded + unloaded
    torque = torque + rig.asymmetry_nm * load_n / REFERENCE_LOAD_N
    # Spring and damper stay when the inertia changes.
    scale = (rig.inertia_kgm2 / inertia_kgm2) ** 0.5
    natural_hz, damping_ratio = rig.natural_hz * scale, rig.damping_ratio * scale
    truth = {
        "starting_torque_nm": starting_torque_nm(loaded, motion),
        "bearing_torque_nm": starting_torque_nm(loaded + unloaded, motion),
        "inertia_kgm2": inertia_kgm2,
        "natural_frequency_hz": natural_hz,
        "damping_ratio": damping_ratio,
        "frequency_hz": frequency_hz,
    }
    return SteadyState(resonate(torque, frequency_hz, natural_hz, damping_ratio), truth)
