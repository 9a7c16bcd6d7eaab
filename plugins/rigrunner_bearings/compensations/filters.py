"""Frequency responses of the filters that a register describes.

Frequencies in Hz, of any shape; responses complex, 1 at rest, of the same shape.
"""

from __future__ import annotations

from functools import lru_cache
from math import acosh, asinh, cos, cosh, pi, sin, sinh, sqrt
from typing import TYPE_CHECKING, cast

import numpy as np
import scipy

from rigrunner.api.filters import Fir, LowPass, MeasuredResponse
from rigrunner_bearings.compensations.response import butterworth

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.compensations.response import Response

Filter = LowPass | Fir | MeasuredResponse
HALF_POWER = 1 / sqrt(2)
BISECTIONS = 60


def response_of(low_pass: Filter, frequency_hz: Array) -> Response:
    """Return the response of a filter."""
    if isinstance(low_pass, Fir):
        taps = np.array(low_pass.taps)
        delay = np.exp(-2j * pi * np.asarray(frequency_hz) / low_pass.rate)
        return np.asarray(np.polynomial.polynomial.polyval(delay, taps / taps.sum()))
    if isinstance(low_pass, MeasuredResponse):
        return _measured(low_pass, frequency_hz)
    if low_pass.type == "butterworth":
        return butterworth(frequency_hz, low_pass.corner, low_pass.order)
    if low_pass.type == "bessel":
        poles = _bessel_poles(low_pass.order)
    else:
        poles = _chebyshev_poles(low_pass.order, cast("float", low_pass.ripple_db))
    over_corner = np.asarray(frequency_hz) / low_pass.corner
    response = np.ones(np.shape(over_corner), complex)
    for pole in poles:
        response = response / (1 - 1j * over_corner / pole)
    return response


def corner_hz(low_pass: Filter) -> float:
    """Return the lowest frequency at which the gain is down by 3 dB; of a table, at most its end.

    Of taps or a table it is searched for in steps of a thousandth of what these reach.
    """
    if isinstance(low_pass, LowPass):
        return low_pass.corner
    reach = low_pass.rate / 2 if isinstance(low_pass, Fir) else low_pass.response[-1].frequency
    steps = np.linspace(0, reach, 1001)
    below = np.flatnonzero(np.abs(response_of(low_pass, steps)) < HALF_POWER)
    if not len(below):
        return reach
    low, high = float(steps[below[0] - 1]), float(steps[below[0]])
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        passes = abs(complex(response_of(low_pass, np.array(middle)))) >= HALF_POWER
        low, high = (middle, high) if passes else (low, middle)
    return high


@lru_cache(maxsize=16)
def _bessel_poles(order: int) -> tuple[complex, ...]:
    """Return the poles of a Bessel filter (maximally flat delay) with its corner at 1."""
    return tuple(map(complex, scipy.signal.besselap(order, norm="mag")[1]))


@lru_cache(maxsize=16)
def _chebyshev_poles(order: int, ripple_db: float) -> tuple[complex, ...]:
    """Return the poles of a Chebyshev filter of type I with its gain down by 3 dB at 1.

    Of the one with its ripple ending at 1: -sinh(m) sin(t) + j cosh(m) cos(t), m = asinh(1/e)/n
    and t = pi (2 k + 1)/(2 n), with e of the ripple. Its squared gain is 1/(1 + e² T_n²), with T_n
    0 at rest of an odd order, and 1 of an even one; all is over the gain at rest.
    """
    e = sqrt(10 ** (ripple_db / 10) - 1)
    half = (1 if order % 2 else sqrt(1 + 2 * e**2)) / e
    m, wider = asinh(1 / e) / order, cosh(acosh(half) / order)
    angles = (pi * (2 * k + 1) / (2 * order) for k in range(order))
    return tuple(complex(-sinh(m) * sin(angle), cosh(m) * cos(angle)) / wider for angle in angles)


def _measured(low_pass: MeasuredResponse, frequency_hz: Array) -> Response:
    """Return a response between the points of a table, and 1 at rest.

    The logarithm of the gain and the phase, unwrapped, are interpolated in straight lines. Beyond
    the table the gain falls with the square of the frequency, and the phase goes on as at its end.
    """
    table = low_pass.response
    hertz = np.array([0.0, *(point.frequency for point in table)])
    gain = np.log([1.0, *(point.gain for point in table)])
    phase = np.unwrap([0.0, *(point.phase for point in table)])
    positive_hz = np.abs(np.asarray(frequency_hz, float))
    beyond = np.maximum(positive_hz / hertz[-1], 1.0)
    slope = (phase[-1] - phase[-2]) / (hertz[-1] - hertz[-2])
    turned = np.interp(positive_hz, hertz, phase) + slope * np.maximum(positive_hz - hertz[-1], 0.0)
    response = np.exp(np.interp(positive_hz, hertz, gain) + 1j * turned) / beyond**2
    return np.asarray(np.where(np.asarray(frequency_hz) < 0, np.conj(response), response))
