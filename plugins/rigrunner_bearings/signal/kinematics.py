"""Swing of an oscillating guide bar (crank and rocker slide), the drive of the swing tester.

A disk turns at constant speed with an eccentric pin e off its centre; the pin's wheel runs in a
slot of the guide bar, which swings about an axis at the distance L from the disk's centre. With the
crank phase phi and lambda = e / L the pin stands at L (1 + lambda cos phi, lambda sin phi)
as seen from the bar's axis, so

    theta = atan2(lambda sin phi, 1 + lambda cos phi)

and velocity and acceleration follow by differentiation at constant w = dphi/dt = 2 pi f. Phase 0 is
the middle of the forward stroke: theta = 0, rising. The forward stroke takes longer than the return
(its peak velocity is lower), and the motion's odd symmetry is theta(-phi) = -theta(phi).

Mechanism: Wang et al., Machines 2025, 13(11), 976, section on the drive, with e = 2 mm, L = 45 mm.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rigrunner.api import Array


def swing_angle(phase_rad: Array, ratio: float) -> Array:
    """Return the swing angle theta in rad at crank phases of any shape."""
    return _angle(phase_rad, np.cos(phase_rad), ratio)


def angular_velocity(phase_rad: Array, frequency_hz: float, ratio: float) -> Array:
    """Return dtheta/dt in rad/s at crank phases of any shape, for a steady crank."""
    return _velocity(np.cos(phase_rad), frequency_hz, ratio)


def angle_and_velocity(phase_rad: Array, frequency_hz: float, ratio: float) -> tuple[Array, Array]:
    """Return `swing_angle` and `angular_velocity` of the same phases, for one cosine."""
    cosine = np.cos(phase_rad)
    return _angle(phase_rad, cosine, ratio), _velocity(cosine, frequency_hz, ratio)


def by_half_angle(phase_rad: Array, ratio: float) -> tuple[Array, Array]:
    """Return `swing_angle` and `angular_velocity` at 1 Hz, to 1e-14 of their amplitudes.

    With t = tan(phi / 2), sine and cosine are 2 t / (1 + t^2) and (1 - t^2) / (1 + t^2): a tangent
    and an arc tangent, in place of a sine, a cosine and arctan2, take a fifth of the time.
    """
    tangent = np.tan(phase_rad / 2)
    squared = tangent**2
    more, less = 1 + ratio, 1 - ratio
    angle = np.arctan(2 * ratio * tangent / (more + less * squared))
    velocity = 2 * math.pi * ratio * (more - less * squared) / (more**2 + less**2 * squared)
    return angle, velocity


def angular_acceleration(phase_rad: Array, frequency_hz: float, ratio: float) -> Array:
    """Return d2theta/dt2 in rad/s2 at crank phases of any shape, for a steady crank."""
    speed = 2 * math.pi * frequency_hz
    numerator = -(speed**2) * ratio * (1 - ratio**2) * np.sin(phase_rad)
    return numerator / _distance_squared(np.cos(phase_rad), ratio) ** 2


def reversal_phase(ratio: float) -> float:
    """Return the crank phase in (0, pi) at which theta is greatest; the other is its negative."""
    return math.acos(-ratio)


def max_angle(ratio: float) -> float:
    """Return the amplitude of theta in rad, half of the whole swing."""
    return math.asin(ratio)


def max_velocity(frequency_hz: float, ratio: float) -> float:
    """Return the greatest (signed) dtheta/dt in rad/s, in the middle of the forward stroke."""
    return 2 * math.pi * frequency_hz * ratio / (1 + ratio)


def max_speed(frequency_hz: float, ratio: float) -> float:
    """Return the greatest |dtheta/dt| in rad/s, in the middle of the faster return stroke."""
    return 2 * math.pi * frequency_hz * ratio / (1 - ratio)


def max_acceleration(frequency_hz: float, ratio: float) -> float:
    """Return the greatest d2theta/dt2 in rad/s2, a little after the reversal.

    It is where d(alpha)/d(phi) = 0: 2 lambda c^2 - (1 + lambda^2) c - 4 lambda = 0, c = cos phi.
    """
    linear = 1 + ratio**2
    cosine = -8 * ratio / (linear + math.sqrt(linear**2 + 32 * ratio**2))
    phase = -math.acos(cosine)
    return float(angular_acceleration(np.array(phase), frequency_hz, ratio))


def _angle(phase_rad: Array, cosine: Array, ratio: float) -> Array:
    return np.arctan2(ratio * np.sin(phase_rad), 1 + ratio * cosine)


def _velocity(cosine: Array, frequency_hz: float, ratio: float) -> Array:
    return 2 * math.pi * frequency_hz * ratio * (ratio + cosine) / _distance_squared(cosine, ratio)


def _distance_squared(cosine: Array, ratio: float) -> Array:
    """Square of the pin's distance from the bar's axis, over L^2."""
    return 1 + ratio**2 + 2 * ratio * cosine
