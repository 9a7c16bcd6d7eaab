"""The no-load torque at any frequency of the range, by a model of the whole sweep.

J, fn, damping and the support's friction over the swing, learned from all frequencies together,
give the sensor's torque at one that was not recorded. It takes the place of a recorded template.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner_bearings.compensations import response
from rigrunner_bearings.compensations.bearing import MeanSwing, mean_swing
from rigrunner_bearings.compensations.harmonics import HARMONICS, spectrum_of
from rigrunner_bearings.compensations.identification import frictions_without_each

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Array
    from rigrunner_bearings.api.points import SwingPoint
    from rigrunner_bearings.compensations.drive_line import DriveLine
    from rigrunner_bearings.compensations.identification import Identified
    from rigrunner_bearings.compensations.support_friction import SupportFriction

ROUNDS = 4
"""The coupling's twist moves the friction, which twists the coupling: soon nothing changes."""

BEYOND = 0.005
"""How far outside the sweep's range, relatively, a frequency may be: that of speed scatter."""


@dataclass(frozen=True, eq=False)
class NoLoadModel:
    """The rig as the no-load sweep shows it, at any frequency within its range.

    `without_each` is the support's friction as learned without each frequency of the sweep;
    `unexplained_nm` is what the model leaves of the torque at each, beyond noise, (frequencies, n).
    """

    rig: Identified
    without_each: tuple[SupportFriction, ...]
    frequencies_hz: Array
    unexplained_nm: Array

    def template(self, frequency_hz: float) -> MeanSwing:
        """Return the sensor's torque at a frequency; its replicates leave out each of the sweep's.

        Raises DataError outside the range of the sweep.
        """
        lowest, highest = self.frequencies_hz[0], self.frequencies_hz[-1]
        if not lowest * (1 - BEYOND) <= frequency_hz <= highest * (1 + BEYOND):
            raise DataError(
                f"{frequency_hz:.4g} Hz is outside of the no-load sweep, "
                f"{lowest:.4g} Hz to {highest:.4g} Hz",
                hint="record the no-load sweep up to the highest and down to the lowest frequency",
            )
        line, friction = self.rig.line, self.rig.friction
        twist = _settled_twist(line, friction, frequency_hz)
        # What is unexplained between the neighbours in frequency.
        unexplained = self.unexplained_nm
        place = np.interp(frequency_hz, self.frequencies_hz, np.arange(len(unexplained)))
        below = min(int(place), len(unexplained) - 2)
        share = place - below
        offset_nm = np.asarray((1 - share) * unexplained[below] + share * unexplained[below + 1])
        torque, *replicates = (
            _sensor_torque(line, support, frequency_hz, twist) + offset_nm
            for support in (friction, *self.without_each)
        )
        return MeanSwing(frequency_hz, torque, np.array(replicates) - torque, of_cycles=False)


def no_load_model(points: Sequence[SwingPoint], rig: Identified) -> NoLoadModel:
    """Return the model of a sweep from which a rig was identified."""
    order = np.argsort([point.frequency_hz.value for point in points])
    ordered = tuple(points[i] for i in order)
    return NoLoadModel(
        rig,
        frictions_without_each(ordered, rig),
        np.array([point.frequency_hz.value for point in ordered]),
        np.array([_unexplained(point, rig) for point in ordered]),
    )


def _unexplained(point: SwingPoint, rig: Identified) -> Array:
    """Return what the model leaves of a point's mean torque, shape (n,), shrunk towards nothing.

    Noise alone leaves something too: the more of the rest it can be, the less of it is kept
    (positive part of James and Stein, Proc. Fourth Berkeley Symp. 1, 1961).
    """
    friction, frequency = rig.friction, point.frequency_hz.value
    mean = mean_swing(point, friction.swing.size)
    twist = _settled_twist(rig.line, friction, frequency)
    remainder = mean.torque_nm - _sensor_torque(rig.line, friction, frequency, twist)
    spectrum = np.fft.rfft(remainder)
    spectrum[0], spectrum[HARMONICS + 1 :] = 0.0, 0.0
    remainder = np.fft.irfft(spectrum, len(remainder))
    changes = spectrum_of(mean.changes_nm)
    count = len(changes)
    # The jackknife's variance of the mean, as a mean square over the phases (Parseval).
    noise = 2 * (count - 1) / count * np.sum(np.abs(changes) ** 2)
    return np.asarray(remainder * max(0.0, 1 - noise / np.mean(remainder**2)))


def _settled_twist(line: DriveLine, friction: SupportFriction, frequency_hz: float) -> Array:
    """Return the coupling's twist over the swing, shape (n,), that goes with its own torque."""
    twist = friction.reference_twist_rad
    for _ in range(ROUNDS):
        torque = response.Waveform(_sensor_torque(line, friction, frequency_hz, twist))
        twist = line.twist(torque, frequency_hz)
    return twist


def _sensor_torque(
    line: DriveLine, friction: SupportFriction, frequency_hz: float, twist_rad: Array
) -> Array:
    """Return the torque of the unloaded rig over the swing as the sensor shows it, shape (n,)."""
    swing = friction.swing
    inertial = line.inertia_kgm2 * swing.acceleration_per_hz2 * frequency_hz**2
    harmonics = np.arange(swing.size // 2 + 1, dtype=float)
    through = np.where(harmonics <= HARMONICS, line.sensor(harmonics * frequency_hz), 0.0)
    load = inertial + friction.measured_torque(frequency_hz, twist_rad, line.share)
    return response.apply(through, load)
