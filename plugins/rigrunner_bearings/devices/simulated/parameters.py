"""The measuring chain and the motion of a simulated tester, in SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass

DEG_RAD = math.pi / 180


@dataclass(frozen=True, kw_only=True)
class SensorParameters:
    """What a recording goes through: motion, transducer, amplifier, converter, encoder.

    The `*_limit` fields are the half-widths of rectangular distributions, from which each rig draws
    its constant errors once. The torque range is symmetric; beyond it the converter clips.
    """

    sample_rate_hz: float = 10e3
    full_scale_nm: float = 10.0
    range_nm: float = 12.0
    adc_bits: int = 16
    noise_nm: float = 0.02
    spike_probability: float = 2e-5
    spike_nm: float = 5.0
    low_pass_hz: float = 1e3
    gain_limit: float = 0.003
    offset_limit_nm: float = 0.02
    drift_limit_nm: float = 0.02
    drift_time_s: float = 600.0
    nonlinearity_limit: float = 5e-4
    torque_delay_s: float = 0.0
    encoder_resolution_rad: float = 0.01 * DEG_RAD
    encoder_noise_rad: float = 0.0
    tacho_noise_rad_s: float = 0.02
    index_phase_rad: float = 0.0
    index_width_rad: float = 20 * DEG_RAD
    speed_jitter: float = 0.0
    frequency_error: float = 0.0


@dataclass(frozen=True, kw_only=True)
class ConstantErrors:
    """The errors that one set-up of a rig has throughout: those of an ideal chain are all zero.

    `drift_nm` is where the zero drifts to; `nonlinearity` is a fraction of full scale.
    """

    gain: float = 0.0
    offset_nm: float = 0.0
    drift_nm: float = 0.0
    nonlinearity: float = 0.0
