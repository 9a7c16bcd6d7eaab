"""Frequency responses of the path from the torque to its samples.

Frequencies in Hz, of any shape; responses complex, dimensionless, of the same shape.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import pi, sin
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rigrunner.api import Array

    Response = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Waveform:
    """Periodic waveforms, shape (..., n), whose harmonics are found once for many responses.

    The values are not to be changed.
    """

    values: Array

    @property
    def size(self) -> int:
        """The number of samples in a period, n."""
        return int(self.values.shape[-1])

    @cached_property
    def spectrum(self) -> Response:
        """The harmonics 0 ... n // 2, as np.fft.rfft scales them, shape (..., n // 2 + 1)."""
        return np.fft.rfft(self.values, axis=-1)

    def through(self, response: Response, size: int = 0) -> Array:
        """Return them filtered, as `apply` does, on their own phases or on `size`."""
        size = size or self.size
        spectrum = self.spectrum[..., : len(response)]
        return np.fft.irfft(spectrum * (response * (size / self.size)), size, axis=-1)


def butterworth(frequency_hz: Array, corner_hz: float, order: int) -> Response:
    """Return the response of an analogue Butterworth low-pass (poles equally spaced on a circle).

    Of the damping terms of its pole pairs, 2 sin((2k + 1) pi / (2 order)).
    """
    q = 1j * np.asarray(frequency_hz) / corner_hz
    denominator = 1 + q if order % 2 else np.ones_like(q)
    for k in range(order // 2):
        denominator = denominator * (1 + 2 * sin((2 * k + 1) * pi / (2 * order)) * q + q**2)
    return np.asarray(1 / denominator)


def torsional_resonance(
    frequency_hz: Array, natural_hz: float, damping_ratio: float | Array
) -> Response:
    """Return the torque in a damped torsional spring over the torque that acts on its inertia.

    (1 + 2 z q)/(1 + 2 z q + q^2) with q = j f / fn: the transmissibility of a mass on a spring and
    damper whose base is driven (Den Hartog, Mechanical Vibrations).
    """
    q = 1j * np.asarray(frequency_hz) / natural_hz
    damped = 1 + 2 * damping_ratio * q
    return np.asarray(damped / (damped + q**2))


def raised_cosine(frequency_hz: Array, flat_to_hz: float, zero_from_hz: float) -> Array:
    """Return a taper: 1 up to flat_to_hz, half a cosine down to 0 at zero_from_hz."""
    span = zero_from_hz - flat_to_hz
    position = np.clip((np.abs(frequency_hz) - flat_to_hz) / span, 0.0, 1.0)
    return np.asarray((1 + np.cos(pi * position)) / 2)


def inverse(response: Response, taper: Array) -> Response:
    """Return the inverse of a response where the taper lets it through, 0 elsewhere."""
    return np.divide(taper, response, out=np.zeros_like(response), where=taper > 0)


def apply(response: Response, waveform: Array) -> Array:
    """Return periodic waveforms of shape (..., n) filtered by a response at its harmonics.

    What a response shorter than n // 2 + 1 does not reach is taken out.
    """
    return Waveform(waveform).through(response)
