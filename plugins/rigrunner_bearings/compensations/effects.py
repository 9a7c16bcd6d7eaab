"""By how much the quantity of a check moves each torque, found in the waveforms themselves.

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
    from rigrunner_bearings.compensations.evaluation import Evaluation
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


def mismatch(evaluation: Evaluation, rig: Identified) -> Mismatch:
    """Return how much of the loaded run's inertia is left in a point's torque."""
    swing, loaded = rig.friction.swing, evaluation.pair.loaded
    inertial = rig.line.inertia_kgm2 * swing.acceleration_per_hz2 * loaded.frequency_hz**2
    unit = float(inertia_in_phase(swing, inertial))
    without_each = [
        jackknife_error(inertia_in_phase(swing, run))[0] / unit
        for run in evaluation.without_each_nm
    ]
    elastic = ELASTIC * evaluation.maximum_nm / float(np.abs(inertial).max())
    total = rig.line.at_load(loaded.waveform, loaded.frequency_hz)
    return Mismatch(
        float(inertia_in_phase(swing, evaluation.bearing_nm)) / unit,
        hypot(*without_each, elastic),
        _slope(evaluation, inertial),
        _slope(evaluation, total),
    )


@dataclass(frozen=True)
class BySpeed:
    """The mean torque under way, and the part of a torque that follows the speed in the result.

    `at_start` is that part over the mean torque under way that it makes.
    """

    running_nm: float
    at_start: float


def by_speed(evaluation: Evaluation, swing: Swing) -> BySpeed:
    """Return the numbers that show whether a torque follows the speed."""
    viscous = swing.velocity_per_hz * evaluation.pair.loaded.frequency_hz
    at_start = _slope(evaluation, viscous) / float(running_torque(swing, viscous))
    return BySpeed(float(running_torque(swing, evaluation.bearing_nm)), at_start)


def _slope(evaluation: Evaluation, torque_nm: Array) -> float:
    more = evaluation.reversals.torque(evaluation.bearing_nm + SMALL * torque_nm)
    return (float(more) - evaluation.maximum_nm) / SMALL


def by_halves(
    no_load: Sequence[SwingPoint],
    rig: Identified,
    evaluations: Sequence[Evaluation],
    window_rad: float,
) -> tuple[Bias, ...]:
    """Return what each torque differs by with the drive line as every second frequency shows it.

    None where half of the frequencies are too few to learn it from.
    """
    ordered = sorted(no_load, key=lambda point: point.frequency_hz.value)
    halves = ordered[::2], ordered[1::2]
    if min(map(len, halves)) < LEAST_FREQUENCIES:
        return ()
    swing, low_pass = rig.friction.swing, rig.line.low_pass
    half_rigs = [identify_again(tuple(half), swing, low_pass, rig) for half in halves]
    pairs = [evaluation.pair for evaluation in evaluations]
    torques = np.array(
        [[starting_torque(r.line, r.friction, p, window_rad) for p in pairs] for r in half_rigs]
    )
    return tuple(
        Bias(f"{pair.loaded.frequency_hz:.4g} Hz", 0.0, float(difference) / 2)
        for pair, difference in zip(pairs, np.abs(torques[0] - torques[1]), strict=True)
    )
