"""The no-load torque at any frequency of the range, as the model of the whole sweep says it is.

J, fn, damping and the support's friction over the swing, learned from all frequencies together,
give the sensor's torque at one that was not recorded. It takes the place of a recorded template.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import DataError
from rigrunner.signal import response
from rigrunner_plugins.compensations.bearing import MeanSwing
from rigrunner_plugins.compensations.identification import HARMONICS, frictions_without_each

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.analysis import SwingPoint
    from rigrunner.api.data import Array
    from rigrunner_plugins.compensations.drive_line import DriveLine
    from rigrunner_plugins.compensations.identification import Identified
    from rigrunner_plugins.compensations.support_friction import SupportFriction

ROUNDS = 4
"""The coupling's twist moves the friction, which twists the coupling: soon nothing changes."""

BEYOND = 0.005
"""How far outside the sweep's range, relatively, a frequency may be: that of speed scatter."""


@dataclass(frozen=True, eq=False)
class NoLoadModel:
    """What the no-load sweep says of the rig, at any frequency within its range.

    `without_each` is the support's friction as learned without each frequency of the sweep.
    """

    rig: Identified
    without_each: tuple[SupportFriction, ...]
    range_hz: tuple[float, float]

    def template(self, frequency_hz: float) -> MeanSwing:
        """Return the sensor's torque at a frequency; its replicates leave out each of the sweep's.

        Raises DataError outside the range of the sweep.
        """
        lowest, highest = self.range_hz
        if not lowest * (1 - BEYOND) <= frequency_hz <= highest * (1 + BEYOND):
            raise DataError(
                f"{frequency_hz:.4g} Hz is outside of the no-load sweep, "
                f"{lowest:.4g} Hz to {highest:.4g} Hz",
                hint="record the no-load sweep up to the highest and down to the lowest frequency",
            )
        line, friction = self.rig.line, self.rig.friction
        twist = _settled_twist(line, friction, frequency_hz)
        torque, *replicates = (
            _sensor_torque(line, each, frequency_hz, twist)
            for each in (friction, *self.without_each)
        )
        return MeanSwing(frequency_hz, torque, np.array(replicates))


def no_load_model(points: Sequence[SwingPoint], rig: Identified) -> NoLoadModel:
    """Return the model of a sweep from which a rig was identified."""
    frequencies = [point.frequency_hz.value for point in points]
    return NoLoadModel(
        rig, frictions_without_each(points, rig), (min(frequencies), max(frequencies))
    )


def _settled_twist(line: DriveLine, friction: SupportFriction, frequency_hz: float) -> Array:
    """Return the coupling's twist over the swing, shape (n,), that goes with its own torque."""
    twist = friction.reference_twist_rad
    for _ in range(ROUNDS):
        twist = line.twist(_sensor_torque(line, friction, frequency_hz, twist), frequency_hz)
    return twist


def _sensor_torque(
    line: DriveLine, friction: SupportFriction, frequency_hz: float, twist_rad: Array
) -> Array:
    """Return the torque of the unloaded rig over the swing as the sensor shows it, shape (n,)."""
    swing = friction.swing
    inertial = line.inertia_kgm2 * swing.acceleration_per_hz2 * frequency_hz**2
    harmonics = np.arange(swing.size // 2 + 1, dtype=float)
    through = np.where(harmonics <= HARMONICS, line.sensor(harmonics * frequency_hz), 0.0)
    load = inertial + friction.seen(frequency_hz, twist_rad, line.share)
    return response.apply(through, load)
