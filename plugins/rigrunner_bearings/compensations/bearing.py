"""The bearing's torque over one swing, and the starting torque in it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner.signal.averaging import mean_and_without_each
from rigrunner_bearings.compensations.response import Waveform
from rigrunner_bearings.compensations.swing import interpolated, strokes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rigrunner.api import Array
    from rigrunner_bearings.api.points import SwingPoint
    from rigrunner_bearings.compensations.drive_line import DriveLine
    from rigrunner_bearings.compensations.support_friction import SupportFriction


REMEMBERED = 40
"""A budget needs up to 34 of one pair: fifteen lines of two runs, and four other frequencies."""


@dataclass(frozen=True, eq=False)
class MeanSwing:
    """The mean torque of one recording over its swing, shape (n,)."""

    frequency_hz: float
    torque_nm: Array
    changes_nm: Array
    """What it changes by without each cycle, shape (cycles, N), on the phases of the cycles."""
    of_cycles: bool = True
    """The changes leave out a cycle each; else what a model learned without a frequency."""
    frequency_u_hz: float = 0.0
    """Of the measured frequency; 0 for a modelled swing, which is at the requested frequency."""

    @cached_property
    def waveform(self) -> Waveform:
        """The mean torque, to be filtered."""
        return Waveform(self.torque_nm)


@dataclass(frozen=True, eq=False)
class Reversals:
    """Where the starting torque is looked for: the samples shortly after each reversal."""

    forward: NDArray[np.intp]
    backward: NDArray[np.intp]

    def of_strokes(self, bearing_nm: Array) -> tuple[Array, Array]:
        """Return the greatest torque against each stroke, of waveforms of shape (..., n)."""
        return (
            bearing_nm[..., self.forward].max(axis=-1),
            -bearing_nm[..., self.backward].min(axis=-1),
        )

    def torque(self, bearing_nm: Array) -> Array:
        """Return their mean: a constant error of the sensor falls out of it."""
        forward, backward = self.of_strokes(bearing_nm)
        return np.asarray((forward + backward) / 2)


def mean_swing(point: SwingPoint, size: int) -> MeanSwing:
    """Return the robust mean over the kept cycles, on `size` phases."""
    mean, replicates = mean_and_without_each(point.torque_nm, point.kept)
    return MeanSwing(
        point.frequency_hz.value,
        interpolated(mean, size),
        replicates - mean,
        frequency_u_hz=point.frequency_hz.u,
    )


@dataclass(frozen=True, eq=False)
class Pair:
    """A loaded run and its template."""

    loaded: MeanSwing
    no_load: MeanSwing


def bearing_torque(line: DriveLine, friction: SupportFriction, pair: Pair) -> Array:
    """Return the torque that only the loaded run has, at the load, shape (n,).

    The difference of the two runs with the drive line undone. What the support's friction differs
    by, because the coupling twists otherwise under load, and what the inertia does if the runs were
    not quite at the same frequency, is taken out.
    """
    return unexplained(line, friction, pair.loaded) - unexplained(line, friction, pair.no_load)


def unexplained(line: DriveLine, friction: SupportFriction, mean: MeanSwing) -> Array:
    """Return what neither inertia nor the support's known friction explains of one run."""
    frequency = mean.frequency_hz
    inertial = line.inertia_kgm2 * friction.swing.acceleration_per_hz2 * frequency**2
    at_load = _at_load(replace(line, inertia_kgm2=0.0, share=0.0), mean)
    return at_load - inertial - _friction(replace(line, harmonics=0), friction, mean)


# A budget varies one quantity at a time. What does not depend on it is cached for one pair, by a
# line without the quantities that each of these functions does not depend on.
@lru_cache(maxsize=REMEMBERED)
def _at_load(line: DriveLine, mean: MeanSwing) -> Array:
    return line.at_load(mean.waveform, mean.frequency_hz)


@lru_cache(maxsize=REMEMBERED)
def _friction(line: DriveLine, friction: SupportFriction, mean: MeanSwing) -> Array:
    return friction.torque(mean.frequency_hz, _twist(line, mean), line.share)


def _twist(line: DriveLine, mean: MeanSwing) -> Array:
    """Return the twist in one run, which shows where friction acts and where the load reverses."""
    return _cached_twist(replace(line, share=0.0, harmonics=0), mean)


@lru_cache(maxsize=REMEMBERED)
def _cached_twist(line: DriveLine, mean: MeanSwing) -> Array:
    return line.twist(mean.waveform, mean.frequency_hz)


def reversals(
    line: DriveLine, friction: SupportFriction, loaded: MeanSwing, window_rad: float
) -> Reversals:
    """Return the samples within the window after each reversal of the load.

    Raises DataError where there is none: the load does not swing as the angle does.
    """
    twist = line.share * _twist(line, loaded)
    forward, backward = (
        stroke.index[(stroke.distance_rad > 0) & (stroke.distance_rad <= window_rad)]
        for stroke in strokes(friction.swing.angle_rad - twist)
    )
    if not (len(forward) and len(backward)):
        raise DataError(
            f"at {loaded.frequency_hz:.4g} Hz the load has no reversal to look behind",
            hint="the torque would twist the coupling by more than the swing: check the signal",
        )
    return Reversals(forward, backward)


def replicates(line: DriveLine, bearing_nm: Array, run: MeanSwing, sign: int) -> Array:
    """Return the bearing's torque without each cycle of one run, shape (cycles, n).

    `sign` is +1 for the loaded run, -1 for the no-load run. That the twist changes too is second
    order.
    """
    change = Waveform(run.changes_nm)
    return bearing_nm + sign * line.at_load(change, run.frequency_hz, len(bearing_nm))


def starting_torque(
    line: DriveLine, friction: SupportFriction, pair: Pair, window_rad: float
) -> float:
    """Return the starting torque in N·m."""
    at_reversals = reversals(line, friction, pair.loaded, window_rad)
    return float(at_reversals.torque(bearing_torque(line, friction, pair)))
