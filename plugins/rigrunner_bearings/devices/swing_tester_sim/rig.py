"""The closed-form rig: inertia, support and bearing, seen through the elastic drive line.

Friction is that of the rigid motion, so that one cycle of the periodic steady state follows from
the crank phase alone; the drive line then acts on the harmonics of the cycle.
"""

from __future__ import annotations

from functools import lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.devices.simulated.sampling import GRID, SimulatedRig, SteadyState
from rigrunner_bearings.devices.swing_tester_sim import friction
from rigrunner_bearings.signal.kinematics import angular_acceleration

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters


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

    Remembered, as a stream needs it twice, and a repeated one again; it knows no noise.
    """
    phase = 2 * np.pi * np.arange(GRID) / GRID
    motion = friction.swing(phase, frequency_hz, rig.eccentric_ratio)
    loaded, unloaded = _bearing(rig, motion, load_n)
    inertia_kgm2 = _inertia(rig, load_n)
    torque = inertia_kgm2 * angular_acceleration(phase, frequency_hz, rig.eccentric_ratio)
    torque = torque + friction.support_torque(rig, motion, load_n) + loaded + unloaded
    torque = torque + rig.asymmetry_nm * load_n / friction.REFERENCE_LOAD_N
    natural_hz, damping_ratio = _resonance(rig, inertia_kgm2)
    truth = {
        "starting_torque_nm": friction.starting_torque_nm(loaded, motion),
        "bearing_torque_nm": friction.starting_torque_nm(loaded + unloaded, motion),
        "inertia_kgm2": inertia_kgm2,
        "natural_frequency_hz": natural_hz,
        "damping_ratio": damping_ratio,
        "frequency_hz": frequency_hz,
    }
    return SteadyState(resonate(torque, frequency_hz, natural_hz, damping_ratio), truth)


def _bearing(rig: RigParameters, motion: friction.Swing, load_n: float) -> tuple[Array, Array]:
    """Return the torque that load induces, and that which the bearing has without load."""
    reference = friction.bearing_torque(rig, motion)
    unloaded = rig.zero_load_torque_nm / rig.starting_torque_nm
    return reference * (load_n / friction.REFERENCE_LOAD_N), reference * unloaded


def _inertia(rig: RigParameters, load_n: float) -> float:
    return rig.inertia_kgm2 * (1 + (rig.loaded_inertia_change if load_n > 0 else 0.0))


def _resonance(rig: RigParameters, inertia_kgm2: float) -> tuple[float, float]:
    """Return natural frequency and damping ratio: spring and damper stay when inertia changes."""
    scale = (rig.inertia_kgm2 / inertia_kgm2) ** 0.5
    return rig.natural_hz * scale, rig.damping_ratio * scale
