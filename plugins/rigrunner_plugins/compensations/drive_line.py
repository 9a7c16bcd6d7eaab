"""The drive line between torque sensor and load: inertia behind a springy, damped coupling.

    sensor = LP H (J alpha + F),  H = (1 + 2 z q)/(1 + 2 z q + q^2),  q = j f / fn

alpha is the drive's acceleration and F the friction that acts on the inertia: one degree of
freedom with a moving base (Den Hartog, Mechanical Vibrations). All waveforms are periodic, one
swing at N phases; their n-th harmonic has the frequency n f.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal import response

if TYPE_CHECKING:
    from rigrunner.api.data import Array
    from rigrunner.api.instruments import LowPass

MAX_HARMONIC = 48
"""What friction at a reversal still has, seen over a whole swing."""

BAND_OVER_RESONANCE = 2.0
TAPER = 1.5
MAX_GAIN = 10.0


@dataclass(frozen=True)
class DriveLine:
    """What the torque sensor sees the load through; SI units.

    `share` is how much of the coupling's twist the friction takes part in: 1 if it acts on the
    sprung side (load), 0 if it follows the drive.
    """

    natural_hz: float
    damping_ratio: float
    inertia_kgm2: float
    share: float
    low_pass: LowPass

    def filter(self, frequency_hz: Array) -> response.Response:
        """Return the response of the low-pass filter of the register."""
        return response.butterworth(frequency_hz, self.low_pass.corner, self.low_pass.order)

    def sensor(self, frequency_hz: Array) -> response.Response:
        """Return sensor over torque on the inertia, LP H."""
        resonance = response.torsional_resonance(frequency_hz, self.natural_hz, self.damping_ratio)
        return self.filter(frequency_hz) * resonance

    def stiffness(self, frequency_hz: Array) -> response.Response:
        """Return the coupling's torque over its twist, k + j w c, in N·m/rad."""
        k = self.inertia_kgm2 * (2 * pi * self.natural_hz) ** 2
        return np.asarray(k * (1 + 2j * self.damping_ratio * frequency_hz / self.natural_hz))

    def band_hz(self, frequency_hz: float) -> float:
        """Return up to where LP H is inverted in full, for swings of that frequency.

        Twice the resonance holds what the friction's step excites; less if the swing's harmonics
        end before, or the inverse would amplify noise more than tenfold.
        """
        band = min(BAND_OVER_RESONANCE * self.natural_hz, MAX_HARMONIC * frequency_hz)
        tried = np.linspace(0.0, band, 400)
        too_much = np.abs(self.sensor(tried)) < 1 / MAX_GAIN
        return float(tried[np.argmax(too_much)]) if too_much.any() else band

    def at_load(self, sensor_nm: Array, frequency_hz: float) -> Array:
        """Return the torque on the inertia, J alpha + F, from the sensor's, shape (..., N)."""
        harmonic_hz = _harmonics(sensor_nm) * frequency_hz
        band = self.band_hz(frequency_hz)
        taper = response.raised_cosine(harmonic_hz, band, TAPER * band)
        return response.apply(response.inverse(self.sensor(harmonic_hz), taper), sensor_nm)

    def twist(self, sensor_nm: Array, frequency_hz: float) -> Array:
        """Return the drive's angle minus the load's in rad, from the sensor's torque (..., N).

        No resonance is undone here, so a wider band does no harm.
        """
        harmonic_hz = _harmonics(sensor_nm) * frequency_hz
        band = min(BAND_OVER_RESONANCE * self.natural_hz, 2 * MAX_HARMONIC * frequency_hz)
        taper = response.raised_cosine(harmonic_hz, band, TAPER * band)
        stiffness = self.filter(harmonic_hz) * self.stiffness(harmonic_hz)
        return response.apply(response.inverse(stiffness, taper), sensor_nm)


def _harmonics(waveform: Array) -> Array:
    return np.arange(waveform.shape[-1] // 2 + 1, dtype=float)
