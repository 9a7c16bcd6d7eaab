"""The elastic drive line between the driven shaft and the swinging mass."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rigrunner.api import Array


def resonate(
    torque_nm: Array, frequency_hz: float, natural_hz: float, damping_ratio: float
) -> Array:
    """Return what the shaft carries of a periodic torque on the mass; one cycle, shape (n,).

    The shaft is driven at one end, so torque passes as force does in base excitation:
    (1 + 2 z q)/(1 + 2 z q + q^2) with q = j f/fn (Den Hartog, Mechanical Vibrations, ch. 2).
    """
    spectrum = np.fft.rfft(torque_nm)
    q = 1j * frequency_hz * np.arange(len(spectrum)) / natural_hz
    elastic = 1 + 2 * damping_ratio * q
    return np.fft.irfft(spectrum * elastic / (elastic + q**2), len(torque_nm))
