"""Recordings of the simulated rigs without a device, for studies of accuracy.

Every `parameters` is a RigParameters (closed form) or an OdeParameters (time domain) of
`rigrunner_bearings.devices.swing_tester_{sim,ode}.parameters`.

    no_load = run_data(RigParameters(), 0, seed=1)
    loaded = run_data(RigParameters(), 1000, seed=1)
    truth = true_starting_torque_nm(RigParameters(), 1000, 35)

A seed is a rig with its constant errors: the same in both runs, whatever the load. Zero readings
and recordings carry noise of their own.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from rigrunner.api.data import Recording, RunData
from rigrunner.api.instruments import Instrument
from rigrunner_bearings.api.rig import RigDescription
from rigrunner_bearings.devices.simulated.parameters import ConstantErrors, SensorParameters
from rigrunner_bearings.devices.simulated.sampling import (
    RigState,
    SimulatedRig,
    SteadyState,
    noise_source,
    rig_source,
    sample,
)
from rigrunner_bearings.devices.simulated.sensor_errors import draw_constant_errors
from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters
from rigrunner_bearings.devices.swing_tester_ode.rig import time_domain_rig
from rigrunner_bearings.devices.swing_tester_sim.rig import closed_form_rig

FREQUENCIES = (1.0, 3.0, 5.0, 8.0, 10.0, 15.0, 18.0, 20.0, 25.0, 30.0, 33.0, 35.0)
SLOW_HZ = 3.0
IDEAL_SENSORS = SensorParameters(
    adc_bits=32,
    noise_nm=0.0,
    spike_probability=0.0,
    low_pass_hz=1e6,
    gain_limit=0.0,
    offset_limit_nm=0.0,
    drift_limit_nm=0.0,
    nonlinearity_limit=0.0,
    encoder_resolution_rad=0.0,
)
RIG_KEYS = {
    "mandrel": "M-01",
    "eccentric": "2 mm",
    "centre_distance": "45 mm",
    "inertia": "0.00233 kg·m²",
    "support_friction": "0.76 N·m",
    "support_damping": "0.31 N·m·s/rad",
    "swing_radius": "10.4 mm",
    "support_load_dependence": "1 %",  # measured: the simulated supports do not change under load
}
RIG = RigDescription.model_validate(RIG_KEYS)
INSTRUMENT = Instrument.model_validate(
    {
        "channel": "tester.torque",
        "serial": "SIM-TQ-01",
        "full_scale": "10 N·m",
        "accuracy": {
            "gain": "0.3 %",
            "offset": "0.02 N·m",
            "drift": "0.02 N·m",
            "nonlinearity": "0.05 %",
        },
        "low_pass": {"type": "butterworth", "order": 2, "corner": "1 kHz"},
    }
)


def make_rig(parameters) -> SimulatedRig:
    """Return the rig of either model's parameters, its steady states remembered."""
    rig = _model(parameters)
    return replace(rig, steady_state=lambda load, hz: _steady_state(parameters, load, hz))


def true_starting_torque_nm(parameters, load_n, frequency_hz) -> float:
    return make_rig(parameters).steady_state(load_n, frequency_hz).truth["starting_torque_nm"]


def simulate(parameters, frequency_hz, load_n, cycles, rng, *, errors=None, elapsed_s=0.0):
    """Return angle in rad and torque in N·m of so many cycles, without constant errors if none."""
    rig = make_rig(parameters)
    samples = round(cycles / frequency_hz * rig.sensors.sample_rate_hz)
    state = RigState(frequency_hz, load_n, elapsed_s)
    return sample(rig, state, samples, errors or ConstantErrors(), rng)


def recordings(
    parameters, load_n, frequencies=FREQUENCIES, seed=0, cycles=None
) -> tuple[Recording, ...]:
    """Return one recording per frequency; 30 cycles (10 up to 3 Hz) unless told otherwise."""
    errors = draw_constant_errors(parameters.sensors, rig_source(seed))
    elapsed_s, finished = 60.0, []
    for frequency in frequencies:
        count = cycles or (10 if frequency <= SLOW_HZ else 30)
        rng = noise_source(seed, RigState(frequency, load_n), 0)
        angle, torque = simulate(
            parameters, frequency, load_n, count, rng, errors=errors, elapsed_s=elapsed_s
        )
        finished.append(_recording(parameters, frequency, load_n, angle, torque))
        elapsed_s += (count + 5) / frequency
    return tuple(finished)


def run_data(
    parameters, load_n, frequencies=FREQUENCIES, seed=0, cycles=None, **changes
) -> RunData:
    """Return a run of the sweep under that load; `changes` replace fields of the RunData."""
    loaded = load_n > 0
    run = RunData(
        run_id=f"{'loaded' if loaded else 'no-load'}-{seed}",
        procedure_id="SSPB-STT-1000" if loaded else "SSPB-NLI",
        procedure_revision="A",
        procedure_title="Starting torque" if loaded else "No-load inertia sweep",
        station_id="simulated",
        started_utc="2026-01-01T12:00:00+00:00" if loaded else "2026-01-01T10:00:00+00:00",
        ended_utc="2026-01-01T13:00:00+00:00" if loaded else "2026-01-01T11:00:00+00:00",
        outcome="completed",
        inputs={"specimen": "DEMO-0001", "operator": "test"},
        rig_keys=RIG_KEYS,
        instruments={"tester.torque": INSTRUMENT},
        zeros={"tester.torque": zero_reading(parameters, seed)},
        recordings=recordings(parameters, load_n, frequencies, seed, cycles),
        digest=f"{seed:064x}",
    )
    return replace(run, **changes)


def zero_reading(parameters, seed) -> float:
    """Return the mean of one second of the torque channel at rest, in N·m."""
    errors = draw_constant_errors(parameters.sensors, rig_source(seed))
    state = RigState(0.0, 0.0, 5.0)
    samples = round(parameters.sensors.sample_rate_hz)
    _, torque = sample(make_rig(parameters), state, samples, errors, noise_source(seed, state, 0))
    return float(np.mean(torque))


@lru_cache(maxsize=128)
def _steady_state(parameters, load_n, frequency_hz) -> SteadyState:
    return _model(parameters).steady_state(load_n, frequency_hz)


def _model(parameters) -> SimulatedRig:
    if isinstance(parameters, OdeParameters):
        return time_domain_rig(parameters)
    return closed_form_rig(parameters)


def _recording(parameters, frequency, load_n, angle, torque) -> Recording:
    return Recording(
        name=f"{frequency:g} Hz",
        rate_hz=parameters.sensors.sample_rate_hz,
        started_utc="2026-01-01T12:00:00+00:00",
        setpoints={"tester.frequency": frequency, "tester.load": load_n},
        channels={"tester.angle": angle, "tester.torque": torque},
        units={
            "tester.angle": "rad",
            "tester.torque": "N·m",
            "tester.frequency": "Hz",
            "tester.load": "N",
        },
        conditions={"tester.load": load_n, "tester.temperature": 296.15},
    )
