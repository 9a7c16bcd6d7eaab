"""The measuring chain: what transducer, amplifier, converter and encoder make of the motion.

transducer  hysteresis (a play operator), gain, cubic non-linearity
amplifier   zero and its drift, hum of the mains, a low-pass filter before the sampling
converter   white noise, saturation, steps
encoder     noise and steps of the drive's angle; the torque may lag behind it
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit
from scipy.signal import butter, sosfilt, sosfilt_zi

from other_physics.model import STEP_S

if TYPE_CHECKING:
    from numpy.random import Generator

    from other_physics.model import Motion

RATE_HZ = 10_000.0
_EVERY = round(1.0 / RATE_HZ / STEP_S)


class Chain(NamedTuple):
    """The errors of one set-up, and of one recording with it."""

    gain: float = 0.0
    """Relative error of the sensitivity."""
    recording_gain: float = 0.0
    """Relative standard deviation of the sensitivity from recording to recording."""
    full_scale_nm: float = 10.0
    cubic: float = 0.0
    """Error at full scale over full scale; none at zero and at 1/sqrt(3) of it the most."""
    hysteresis: float = 0.0
    """Width over full scale."""
    zero_nm: float = 0.0
    drift_nm: float = 0.0
    drift_s: float = 900.0
    hum_nm: float = 0.0
    hum_hz: float = 50.0
    low_pass_hz: float = 1000.0
    order: int = 2
    noise_nm: float = 0.02
    range_nm: float = 12.0
    bits: int = 16
    encoder_step_rad: float = np.radians(0.01)
    encoder_noise_rad: float = 0.0
    torque_lag_s: float = 0.0

    @property
    def step_nm(self) -> float:
        """Step of the converter."""
        return 2.0 * self.range_nm / 2**self.bits


def measured(
    motion: Motion, chain: Chain, begun_s: float, rng: Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return angle (rad) and torque (N.m) at RATE_HZ, each of shape (n,), as they are stored.

    `begun_s` is how long after the set-up the recording begins.
    """
    torque = _with_hysteresis(motion.gauge_nm, chain.hysteresis * chain.full_scale_nm)
    share = torque / chain.full_scale_nm
    torque = torque + chain.cubic * chain.full_scale_nm * (share**3 - share)
    torque *= (1.0 + chain.gain) * (1.0 + chain.recording_gain * rng.standard_normal())
    now_s = begun_s + motion.time_s
    torque += chain.zero_nm + chain.drift_nm * (1.0 - np.exp(-now_s / chain.drift_s))
    hum = np.sin(2.0 * np.pi * (chain.hum_hz * now_s + rng.uniform()))
    torque += chain.hum_nm * hum
    sections = butter(chain.order, chain.low_pass_hz, fs=1.0 / STEP_S, output="sos")
    torque, _ = sosfilt(sections, torque, zi=sosfilt_zi(sections) * torque[0])
    lag = round(chain.torque_lag_s / STEP_S)
    torque = np.concatenate((np.full(lag, torque[0]), torque[: len(torque) - lag]))[::_EVERY]
    torque = torque + chain.noise_nm * rng.standard_normal(len(torque))
    angle = motion.drive_rad[::_EVERY]
    angle = angle + chain.encoder_noise_rad * rng.standard_normal(len(angle))
    torque = np.clip(torque, -chain.range_nm, chain.range_nm - chain.step_nm)
    return _stepped(angle, chain.encoder_step_rad), _stepped(torque, chain.step_nm)


def _stepped(values: np.ndarray, step: float) -> np.ndarray:
    return values if step == 0.0 else step * np.round(values / step)


@njit(cache=True)
def _with_hysteresis(torque: np.ndarray, width: float) -> np.ndarray:
    """Return what the transducer shows: half the width behind, on the way up and down."""
    out = np.empty_like(torque)
    behind = 0.0
    for i in range(len(torque)):
        behind = min(max(behind, torque[i] - width), torque[i] + width)
        out[i] = torque[i] + 0.5 * (behind - torque[i])
    return out
