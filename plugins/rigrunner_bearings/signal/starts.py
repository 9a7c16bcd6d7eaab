"""The breakaway torque of a start from rest: the greatest in the first travel."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

import numpy as np
import scipy

from rigrunner.api import DataError
from rigrunner_bearings.api.requirements import LEAST_REST_S

if TYPE_CHECKING:
    from rigrunner.api import Array


@dataclass(frozen=True)
class Start:
    """What a recording of a start shows."""

    breakaway_nm: float
    travel_rad: float
    """Where the greatest torque was."""
    frequency_hz: float
    """Turns per second, after the first travel."""


def find_start(
    angle_rad: Array, torque_nm: Array, rate_hz: float, window_rad: float, smoothing_s: float
) -> Start:
    """Return the start that is in angle and torque, both of shape (n,).

    The torque counts in the direction of rotation, from the beginning of the recording until the
    travel is beyond the window. It is the greatest of a running mean over `smoothing_s`: the
    greatest of noisy samples would be high by the noise's extreme value. Raises DataError where
    there is no rest to begin with, or too little travel.
    """
    travel = angle_rad - np.median(angle_rad[: max(1, round(LEAST_REST_S * rate_hz))])
    sense = 1.0 if travel[-1] >= 0 else -1.0
    travel = sense * travel
    moving, end = _first_beyond(travel, window_rad / 10), _first_beyond(travel, window_rad)
    if moving < LEAST_REST_S * rate_hz:
        raise DataError("it does not begin with rest", hint="begin to record before it moves")
    if end > len(travel) - 2:
        raise DataError(
            f"it turns by {np.degrees(travel[-1]):.3g} deg, but more than"
            f" {np.degrees(window_rad):.3g} deg are needed",
            hint="record longer, or turn faster",
        )
    width = max(1, round(smoothing_s * rate_hz))
    smooth = scipy.ndimage.uniform_filter1d(sense * torque_nm, width, mode="nearest")[:end]
    peak = int(np.argmax(smooth))
    turns = (travel[-1] - travel[end]) / (2 * pi)
    frequency_hz = turns * rate_hz / (len(travel) - 1 - end)
    return Start(float(smooth[peak]), float(travel[peak]), float(frequency_hz))


def _first_beyond(travel_rad: Array, limit_rad: float) -> int:
    """Return the index of the first sample beyond a travel; the number of samples if none is."""
    beyond = travel_rad > limit_rad
    return int(np.argmax(beyond)) if beyond.any() else len(travel_rad)
