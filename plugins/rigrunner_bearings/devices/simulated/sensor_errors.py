"""The errors of the sensors: from true torque and angle to the output of converter and encoder."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.devices.simulated.parameters import ConstantErrors

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.devices.simulated.parameters import SensorParameters

SMALLEST_SPIKE = 0.2
"""Smallest spike as a share of the largest; a smaller disturbance would be noise."""


def draw_constant_errors(sensors: SensorParameters, rng: np.random.Generator) -> ConstantErrors:
    """Draw the errors of one set-up, each from its rectangular distribution (GUM 4.3.7)."""
    gain, offset, drift, nonlinearity = rng.uniform(-1, 1, 4)
    return ConstantErrors(
        gain=gain * sensors.gain_limit,
        offset_nm=offset * sensors.offset_limit_nm,
        drift_nm=drift * sensors.drift_limit_nm,
        nonlinearity=nonlinearity * sensors.nonlinearity_limit,
    )


def read_torque(
    torque_nm: Array,
    elapsed_s: Array,
    sensors: SensorParameters,
    errors: ConstantErrors,
    rng: np.random.Generator,
) -> Array:
    """Return the torque as the converter gives it, in N·m, from the true one; both of shape (n,).

    `elapsed_s`, shape (n,), is the time since the set-up, over which the zero drifts. The
    non-linearity is a cubic that vanishes at zero and at full scale and is largest between.
    """
    relative = torque_nm / sensors.full_scale_nm
    # x - x³ is 2/(3 √3) at most, at x = 1/√3: so this is 1 there.
    cubic = 1.5 * np.sqrt(3) * (relative - relative**3)
    drift = -np.expm1(-elapsed_s / sensors.drift_time_s) * errors.drift_nm
    signal = (1 + errors.gain) * torque_nm + errors.offset_nm + drift
    signal = signal + errors.nonlinearity * sensors.full_scale_nm * cubic
    signal = signal + sensors.noise_nm * rng.standard_normal(len(signal))
    # Single samples are disturbed, by either sign.
    hit = np.flatnonzero(rng.random(len(signal)) < sensors.spike_probability)
    size = sensors.spike_nm * rng.uniform(SMALLEST_SPIKE, 1, len(hit))
    signal[hit] += size * rng.choice([-1.0, 1.0], len(hit))
    # The converter rounds to its steps and clips to its range.
    step = 2 * sensors.range_nm / 2**sensors.adc_bits
    return np.asarray(
        np.clip(np.rint(signal / step) * step, -sensors.range_nm, sensors.range_nm - step)
    )


def read_angle(angle_rad: Array, sensors: SensorParameters, rng: np.random.Generator) -> Array:
    """Return the angle as the encoder gives it, in rad, from the true one; both of shape (n,)."""
    noisy = angle_rad + sensors.encoder_noise_rad * rng.standard_normal(len(angle_rad))
    if sensors.encoder_resolution_rad == 0:
        return noisy
    return np.rint(noisy / sensors.encoder_resolution_rad) * sensors.encoder_resolution_rad


def read_index(phase_rad: Array, sensors: SensorParameters) -> Array:
    """Return 1 while the mark passes the index sensor, else 0, at crank phases of shape (n,)."""
    passed = (phase_rad - sensors.index_phase_rad) % (2 * np.pi)
    return (passed < sensors.index_width_rad).astype(float)
