"""Runs of the simulated rigs with an angle, a tacho, an index pulse or no motion channel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from helpers_rigs import FREQUENCIES, make_rig, run_data
from rigrunner_bearings.devices.simulated.sampling import (
    RigState,
    noise_source,
    rig_source,
    sample_channels,
)
from rigrunner_bearings.devices.simulated.sensor_errors import draw_constant_errors
from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters

UNITS = {"angle": "rad", "velocity": "rad/s", "index": "1"}
BY_ENTRY = "none"
"""Only the torque is recorded."""


def run_by(motion, parameters, load_n, frequencies=FREQUENCIES, *, seed=0, cycles=30):
    """Return a run with torque and one channel of UNITS, or with torque alone for BY_ENTRY."""
    short = run_data(parameters, load_n, frequencies, seed, cycles=1)
    names = ("torque",) if motion == BY_ENTRY else ("torque", motion)
    recordings = (
        _record_again(recording, parameters, seed, cycles) for recording in short.recordings
    )
    return replace(
        short, recordings=tuple(_with_channels(recording, names) for recording in recordings)
    )


def random_rig(model, seed):
    """Return a rig of 'closed' form or 'ode' with random mechanics, and its sensors."""
    rng = np.random.default_rng(seed)
    low, high = rng.uniform(0.85, 1.15, (2, 4))
    if model == "ode":
        rig = OdeParameters()
        return replace(
            rig,
            inertia_kgm2=rig.inertia_kgm2 * low[0],
            natural_hz=rng.uniform(300, 600),
            damping_ratio=rng.uniform(0.03, 0.07),
            support_friction_nm=rig.support_friction_nm * low[1],
            kinetic_torque_nm=rig.kinetic_torque_nm * low[2],
            overshoot_nm=rig.overshoot_nm * high[0],
        )
    rig = RigParameters()
    return replace(
        rig,
        inertia_kgm2=rig.inertia_kgm2 * low[0],
        natural_hz=rng.uniform(300, 600),
        damping_ratio=rng.uniform(0.03, 0.07),
        support_friction_nm=rig.support_friction_nm * low[1],
        starting_torque_nm=rig.starting_torque_nm * low[2],
        kinetic_torque_nm=rig.kinetic_torque_nm * low[2],
    )


def _record_again(recording, parameters, seed, cycles):
    """Record again with every channel and this number of cycles."""
    hertz, load_n = (recording.setpoints[f"tester.{name}"] for name in ("frequency", "load"))
    errors = draw_constant_errors(parameters.sensors, rig_source(seed))
    state = RigState(hertz, load_n, 60.0)
    samples = round(cycles / hertz * parameters.sensors.sample_rate_hz)
    rng = noise_source(seed, state, 0)
    by_channel = sample_channels(make_rig(parameters), state, samples, errors, rng)
    return replace(
        recording,
        channels={f"tester.{name}": values for name, values in by_channel.items()},
        units=dict(recording.units) | {f"tester.{name}": unit for name, unit in UNITS.items()},
    )


def _with_channels(recording, names):
    channels = {f"tester.{name}": recording.channels[f"tester.{name}"] for name in names}
    return replace(recording, channels=channels)
