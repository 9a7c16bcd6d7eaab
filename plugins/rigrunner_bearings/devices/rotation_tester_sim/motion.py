"""The motion of a start: rest, even acceleration, even speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rigrunner.api import Array

REST_S = 0.25
"""A recorded start begins with so much rest."""


def start(time_s: Array, speed_rad_s: float, acceleration_rad_s2: float) -> tuple[Array, Array]:
    """Return travel in rad and acceleration in rad/s² at times of shape (n,)."""
    moving_s = np.maximum(time_s - REST_S, 0.0)
    until_s = speed_rad_s / acceleration_rad_s2
    gaining_s = np.minimum(moving_s, until_s)
    travel = acceleration_rad_s2 * gaining_s**2 / 2 + speed_rad_s * (moving_s - gaining_s)
    accelerating = (time_s >= REST_S) & (moving_s < until_s)
    return travel, np.where(accelerating, acceleration_rad_s2, 0.0)
