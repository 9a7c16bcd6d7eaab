"""By how much what a check looks at moves each torque, found in the waveforms themselves.

Friction is opposite in both strokes, and inertia alike: what of the bearing's torque follows the
acceleration in the middle of the swing is none of the bearing's. It is of an inertia, or of a gain,
that differs between the two runs.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.analysis import Bias
from rigrunner.signal.repeatability import jackknife_error
from rigrunner_bearings.compensations.bearing import starting_torque
from rigrunner_bearings.compensations.identification import identify_again
from rigrunner_bearings.compensations.requirements import LEAST_FREQUENCIES
from rigrunner_bearings.compensations.swing import inertia_in_phase, running_torque

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Array
    from rigrunner_bearings.api.points import SwingPoint
    from rigrunner_bearings.compensations.evaluation import Evaluated
    from rigrunner_bearings.compensations.identification import Identified
    from rigrunner_bearings.compensations.swing import Swing

ELASTIC = 0.005
"""Of the torque: what is elastic or presliding in it differs by so much between the set-points."""

SMALL = 1e-3
"""Relative change by which a slope is found."""


@dataclass(frozen=True)
class Mismatch:
    """What of one point follows the acceleration, over the torque of the inertia, and its u."""

    value: float
    u: float
    by_inertia_nm: float
    """The change of the torque with it, if it is of the inertia."""
    by_gain_nm: float
    """The same if it is of the gain: the loaded run's torque has friction too."""


def mismatch(found: Evaluated, rig: Identified) -> Mismatch:
    """Return how much of the loaded run's inertia is left in a point's torque."""
    swing, loaded = rig.friction.swing, found.pair.loaded
    inertial = rig.line.inertia_kgm2 * swing.acceleration_per_hz2 * loaded.frequency_hz**2
    unit = float(inertia_in_phase(swing, inertial))
    without = [
        jackknife_error(inertia_in_phase(swing, run))[0] / unit for run in found.without_each_nm
    ]
    elastic = ELASTIC * found.maximum_nm / float(np.abs(inertial).max())
    total = rig.line.at_load(loaded.waveform, loaded.frequency_hz)
    return Mismatch(
        float(inertia_in_phase(swing, found.bearing_nm)) / unit,
        hypot(*without, elastic),
        _slope(found, inertial),
        _slope(found, total),
    )


@dataclass(frozen=True)
class BySpeed:
    """The mean torque under way, and what of a torque that follows the speed is in the result.

    `at_start` is that part over the mean torque under way that it makes.
    """

    running_nm: float
    at_start: float


def by_speed(found: Evaluated, swing: Swing) -> BySpeed:
    """Return what tells whether a torque follows the speed."""
    viscous = swing.velocity_per_hz * found.pair.loaded.frequency_hz
    at_start = _slope(found, viscous) / float(running_torque(swing, viscous))
    return BySpeed(float(running_torque(swing, found.bearing_nm)), at_start)


def _slope(found: Evaluated, torque_nm: Array) -> float:
    more = found.where.torque(found.bearing_nm + SMALL * torque_nm)
    return (float(more) - found.maximum_nm) / SMALL


def by_halves(
    no_load: Sequence[SwingPoint], rig: Identified, found: Sequence[Evaluated], window_rad: float
) -> tuple[Bias, ...]:
    """Return what each torque differs by with the drive line as every second frequency shows it.

    None where half of the frequencies are too few to learn it from.
    """
    ordered = sorted(no_load, key=lambda point: point.frequency_hz.value)
    halves = ordered[::2], ordered[1::2]
    if min(map(len, halves)) < LEAST_FREQUENCIES:
        return ()
    swing, low_pass = rig.friction.swing, rig.line.low_pass
    lines = [identify_again(tuple(half), swing, low_pass, rig) for half in halves]
    torques = np.array(
        [
            [starting_torque(each.line, each.friction, one.pair, window_rad) for one in found]
            for each in lines
        ]
    )
    return tuple(
        Bias(f"{one.pair.loaded.frequency_hz:.4g} Hz", 0.0, float(apart) / 2)
        for one, apart in zip(found, np.abs(torques[0] - torques[1]), strict=True)
    )
