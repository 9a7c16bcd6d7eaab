"""From a rig's periodic steady state to sampled channels."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.devices.simulated.sensor_errors import read_angle, read_index, read_torque
from rigrunner_bearings.signal.kinematics import angular_velocity, swing_angle

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping

    from rigrunner.api import Array
    from rigrunner_bearings.devices.simulated.parameters import ConstantErrors, SensorParameters

GRID = 2**16
"""Points per cycle from which samples are interpolated linearly: 164 a period of 400 Hz at 1 Hz."""


@dataclass(frozen=True, eq=False)
class SteadyState:
    """One cycle of the rig, shape (n,) over crank phases 2 pi k / n, and what is true of it.

    The torque is that in the transducer's shaft, before any electronics. `truth` holds what
    `KnowsTruth.truth` returns, with units in its names.
    """

    torque_nm: Array
    truth: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class SimulatedRig:
    """A rig's mechanics and its measuring chain."""

    eccentric_ratio: float
    steady_state: Callable[[float, float], SteadyState]
    """Gives one cycle under a load in N at a frequency in Hz."""
    sensors: SensorParameters


@dataclass(frozen=True)
class RigState:
    """Where the drives stand, and for how long the set-up has been drifting."""

    frequency_hz: float
    load_n: float
    elapsed_s: float = 0.0


def noise_source(seed: int, state: RigState, repetition: int) -> np.random.Generator:
    """Return the random numbers of one recording: the same whatever was recorded before it."""
    setpoint = (round(state.frequency_hz * 1e6), round(state.load_n * 1e6))
    return np.random.default_rng([seed, 1, *setpoint, repetition])


def rig_source(seed: int) -> np.random.Generator:
    """Return the random numbers from which a rig's constant errors are drawn."""
    return np.random.default_rng([seed, 0])


def sample(
    rig: SimulatedRig,
    state: RigState,
    samples: int,
    errors: ConstantErrors,
    rng: np.random.Generator,
) -> tuple[Array, Array]:
    """Return angle in rad and torque in N·m as recorded, both of shape (samples,)."""
    channels = sample_channels(rig, state, samples, errors, rng, names=())
    return channels["angle"], channels["torque"]


def sample_channels(
    rig: SimulatedRig,
    state: RigState,
    samples: int,
    errors: ConstantErrors,
    rng: np.random.Generator,
    *,
    names: Collection[str] = ("velocity", "index"),
) -> dict[str, Array]:
    """Return angle, torque, velocity and index as recorded, each of shape (samples,), SI units.

    Velocity and index only where `names` has them: most recordings are without them.
    The recording starts at a random phase. The true frequency is the set one times
    1 + frequency_error; at 0 Hz the rig rests in mid-stroke, without torque.
    """
    time_s = np.arange(samples) / rig.sensors.sample_rate_hz
    angle, torque, velocity, index = np.zeros((4, samples))
    frequency_hz = true_frequency_hz(rig, state)
    if frequency_hz > 0:
        phase, deviation = _turn(time_s, frequency_hz, rig.sensors.speed_jitter, rng)
        angle = swing_angle(phase, rig.eccentric_ratio)
        torque = _torque(rig, frequency_hz, state.load_n, phase, deviation)
        if "velocity" in names:
            turning_hz = frequency_hz * (1 + deviation)
            velocity = turning_hz * angular_velocity(phase, 1.0, rig.eccentric_ratio)
        if "index" in names:
            index = read_index(phase, rig.sensors)
    # A source of its own: the noise of torque and angle stays what it is without the tacho's.
    tacho = rng.spawn(1)[0]
    channels = {
        "torque": read_torque(torque, state.elapsed_s + time_s, rig.sensors, errors, rng),
        "angle": read_angle(angle, rig.sensors, rng),
        "index": index,
    }
    if "velocity" in names:
        noise = rig.sensors.tacho_noise_rad_s * tacho.standard_normal(samples)
        channels["velocity"] = velocity + noise
    return channels


def true_frequency_hz(rig: SimulatedRig, state: RigState) -> float:
    """Return the frequency at which the rig really swings."""
    return state.frequency_hz * (1 + rig.sensors.frequency_error)


def _turn(
    time_s: Array, frequency_hz: float, jitter: float, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return crank phase in rad, and each sample's relative deviation of the speed of its turn."""
    start = rng.uniform()
    # Enough of them even if all were faster by ten standard deviations, and one that was begun.
    turns = math.ceil((time_s[-1] * frequency_hz + 1) * (1 + 10 * jitter)) + 1
    deviation = jitter * rng.standard_normal(turns)
    ends = np.concatenate([[0.0], np.cumsum(1 / (frequency_hz * (1 + deviation)))])
    elapsed = time_s + start * ends[1]
    turn = np.searchsorted(ends, elapsed, side="right") - 1
    phase: Array = 2 * np.pi * (elapsed - ends[turn]) * frequency_hz * (1 + deviation[turn])
    return phase, deviation[turn]


def _torque(
    rig: SimulatedRig, frequency_hz: float, load_n: float, phase: Array, deviation: Array
) -> Array:
    """Return the filtered torque at each phase, to first order in the deviation of speed."""
    position = phase * (GRID / (2 * np.pi))
    before = np.minimum(position.astype(int), GRID - 1)
    beyond = position - before

    def at(hz: float) -> Array:
        cycle = _filtered_cycle(rig.steady_state(load_n, hz), hz, rig.sensors)
        values: Array = cycle[before] + beyond * (cycle[before + 1] - cycle[before])
        return values

    torque = at(frequency_hz)
    jitter = rig.sensors.speed_jitter
    if jitter == 0:
        return torque
    change = at(frequency_hz * (1 + jitter)) - torque
    return torque + change * (deviation / jitter)


@lru_cache(maxsize=4)  # single readings follow each other at one set-point
def _filtered_cycle(steady: SteadyState, frequency_hz: float, sensors: SensorParameters) -> Array:
    """Pass a cycle through a second-order Butterworth low-pass and the delay.

    Return it at GRID points and at the first of the next cycle, not to be written to.
    """
    spectrum = np.fft.rfft(steady.torque_nm)[: GRID // 2 + 1]
    hertz = frequency_hz * np.arange(len(spectrum))
    q = 1j * hertz / sensors.low_pass_hz
    delay = np.exp(-2j * np.pi * hertz * sensors.torque_delay_s)
    response = delay / (1 + math.sqrt(2) * q + q**2)
    cycle = np.fft.irfft(spectrum * response, GRID) * (GRID / len(steady.torque_nm))
    closed = np.append(cycle, cycle[0])
    closed.setflags(write=False)
    return closed
