"""The harmonics of the no-load torque at each frequency, with their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner.signal.averaging import robust_mean

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rigrunner.api import Array
    from rigrunner_bearings.api.points import SwingPoint
    from rigrunner_bearings.compensations.swing import Swing

    Complex = NDArray[np.complex128]

HARMONICS = 72
"""Number of harmonics of a swing; those above a quarter of the sampling rate are not used."""
SENSOR = "is the torque sensor connected, its amplifier switched on, and the channel correct?"
REMEMBERED = 48
"""Points of two sweeps."""
MODEL_ERROR = 1e-4
"""Error of each harmonic by the steps of an encoder and the non-linearity of a good transducer, as
a share of the rms of the torque."""


@dataclass(frozen=True, eq=False)
class Observed:
    """Harmonics 1..K of the no-load torque, one row per frequency."""

    frequency_hz: Array
    """Shape (F, 1)."""
    harmonics: Complex
    """Shape (F, K)."""
    weight: Array
    """1 over the standard uncertainty of a harmonic; 0 where it is not used. Shape (F, K)."""
    acceleration: Complex
    """Harmonics of the angular acceleration at 1 Hz, from the kinematics, shape (K,)."""

    @cached_property
    def harmonic_hz(self) -> Array:
        """The frequency of each harmonic, shape (F, K)."""
        return self.frequency_hz * np.arange(1, self.harmonics.shape[1] + 1)

    def without(self, row: int) -> Observed:
        """Return all but one frequency."""
        return replace(
            self,
            frequency_hz=np.delete(self.frequency_hz, row, 0),
            harmonics=np.delete(self.harmonics, row, 0),
            weight=np.delete(self.weight, row, 0),
        )


def observe(points: tuple[SwingPoint, ...], swing: Swing) -> Observed:
    """Return the harmonics of the mean swing of each point, with their weights.

    Raises DataError for a torque that is the same in all cycles: it is not measured.
    """
    frequency = np.array([[p.frequency_hz.value] for p in points])
    rate = np.array([[p.sample_rate_hz] for p in points])
    means, u = zip(*map(_harmonics_of, points), strict=True)
    if not all(u):
        without_noise = frequency[:, 0][np.array(u) == 0]
        where = ", ".join(f"{hz:.3g} Hz" for hz in without_noise)
        raise DataError(
            f"the no-load torque at {where} is the same in all cycles, without any noise",
            hint=SENSOR,
        )
    used = frequency * np.arange(1, HARMONICS + 1) < rate / 4
    acceleration = spectrum_of(swing.acceleration_per_hz2)
    return Observed(frequency, np.array(means), used / np.array(u)[:, None], acceleration)


# Remembered: points are observed again with each candidate swing and filter, and by halves.
@lru_cache(maxsize=REMEMBERED)
def mean_torque(point: SwingPoint) -> Array:
    """Return the robust mean over a point's kept cycles, shape (N,)."""
    return robust_mean(point.torque_nm, point.kept)[0]


@lru_cache(maxsize=REMEMBERED)
def _harmonics_of(point: SwingPoint) -> tuple[Complex, float]:
    """Return the harmonics of a point's mean swing, and the standard uncertainty of each.

    It is the scatter of the kept cycles combined with `MODEL_ERROR`.
    """
    mean, scatter = mean_torque(point), spectrum_of(point.torque_nm[point.kept])
    variance = scatter.var(axis=0, ddof=1) / len(scatter)
    u = float(np.hypot(np.sqrt(variance.mean()), MODEL_ERROR * mean.std()))
    return spectrum_of(mean), u


def spectrum_of(waveform: Array) -> Complex:
    """Return the harmonics 1..K of waveforms of shape (..., N), shape (..., K)."""
    spectrum: Complex = np.fft.rfft(waveform, axis=-1)[..., 1 : HARMONICS + 1]
    return np.asarray(spectrum / waveform.shape[-1])


def waveform_of(spectrum: Complex, size: int) -> Array:
    """Return the waveform of `size` samples that has these harmonics."""
    padded = np.zeros(size // 2 + 1, complex)
    padded[1 : HARMONICS + 1] = spectrum
    return np.fft.irfft(padded, size) * size
