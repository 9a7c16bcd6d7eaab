"""The drive line between torque sensor and load: inertia behind a springy, damped coupling.

    sensor = LP D H (J alpha + F),  H = (1 + 2 z q)/(1 + 2 z q + q^2),  q = j f / fn

alpha is the drive's acceleration and F the friction that acts on the inertia: one degree of
freedom with a moving base (Den Hartog, Mechanical Vibrations). D is a delay of the torque channel
behind the angle channel. All waveforms are periodic, one swing at N phases; their n-th harmonic has
the frequency n f.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, pi
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.compensations import response
from rigrunner_bearings.compensations.filters import response_of

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.compensations.filters import Filter
    from rigrunner_bearings.compensations.response import Waveform

HARMONICS = 24
"""Of the swing, up to which it is undone: enough for presliding over a fiftieth of the swing."""

TWIST_HARMONICS = 48
"""Of the twist, where no resonance is undone, and so less noise amplified."""

TAPER = 1.5
# Chosen among limits that were tried on simulated rigs (docs/decisions/0036-methods-tried.md).
MAX_GAIN = 2.5


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
    delay_s: float
    low_pass: Filter
    harmonics: int = HARMONICS

    def channel(self, frequency_hz: Array) -> response.Response:
        """Return the response of the torque channel: the register's low-pass filter, and delay."""
        low_pass = response_of(self.low_pass, frequency_hz)
        if not self.delay_s:
            return low_pass  # most lines have none, and its exponential takes as long as the rest
        return np.asarray(low_pass * np.exp(-2j * pi * frequency_hz * self.delay_s))

    def sensor(self, frequency_hz: Array) -> response.Response:
        """Return sensor over torque on the inertia, LP D H."""
        resonance = response.torsional_resonance(frequency_hz, self.natural_hz, self.damping_ratio)
        return self.channel(frequency_hz) * resonance

    def stiffness(self, frequency_hz: Array) -> response.Response:
        """Return the coupling's torque over its twist, k + j w c, in N·m/rad."""
        k = self.inertia_kgm2 * (2 * pi * self.natural_hz) ** 2
        return np.asarray(k * (1 + 2j * self.damping_ratio * frequency_hz / self.natural_hz))

    def at_load(self, sensor_nm: Waveform, frequency_hz: float, size: int = 0) -> Array:
        """Return the torque on the inertia, J alpha + F, from the sensor's, shape (..., N).

        On as many phases, or on `size`.
        """
        share = self.harmonics / HARMONICS
        harmonic_hz = _harmonics(sensor_nm.size, HARMONICS, share) * frequency_hz
        inverse = _inverse(self.sensor(harmonic_hz), HARMONICS, share)
        return sensor_nm.through(inverse, size)

    def twist(self, sensor_nm: Waveform, frequency_hz: float) -> Array:
        """Return the drive's angle minus the load's in rad, from the sensor's torque (..., N)."""
        harmonic_hz = _harmonics(sensor_nm.size, TWIST_HARMONICS) * frequency_hz
        inverse = _inverse(self.channel(harmonic_hz), TWIST_HARMONICS)
        return sensor_nm.through(inverse / self.stiffness(harmonic_hz))


def _inverse(through: response.Response, harmonics: int, share: float = 1.0) -> response.Response:
    """Return the inverse of a response at the harmonics 0, 1, 2, ...

    In full up to that many, or to where it would amplify noise more than MAX_GAIN fold, or to a
    share of either; then tapered.
    """
    too_little = np.flatnonzero(np.abs(through[:harmonics]) < 1 / MAX_GAIN)
    band = share * (float(too_little[0]) if len(too_little) else float(harmonics))
    taper = response.raised_cosine(np.arange(len(through), dtype=float), band, TAPER * band)
    return response.inverse(through, taper)


def _harmonics(size: int, harmonics: int, share: float = 1.0) -> Array:
    """Return the harmonics 0, 1, 2, ... of `size` samples, as far as `_inverse` passes them."""
    reach = ceil(TAPER * share * harmonics)
    return np.arange(min(reach, size // 2) + 1, dtype=float)
