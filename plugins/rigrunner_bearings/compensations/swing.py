"""One swing on a grid of crank phases, and its two strokes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner_bearings.signal.kinematics import angular_acceleration, angular_velocity, swing_angle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from rigrunner.api import Array
    from rigrunner_bearings.api.points import SwingPoint

GRID = 4096
MIDDLE = 0.25
"""Of the amplitude: so far from the reversals no friction of them is left."""

BUILT_UP = 0.7
"""Of the amplitude: up to there what is left of it is a small part."""


@dataclass(frozen=True, eq=False)
class Stroke:
    """The samples from one reversal to before the next, in order, and how far they have come.

    `index` has their places; `distance_rad` is the angle since the reversal, never falling.
    """

    index: NDArray[np.intp]
    distance_rad: Array


@dataclass(frozen=True, eq=False)
class Swing:
    """The drive's motion at the crank phases 2 pi i / n, arrays of shape (n,).

    `velocity_per_hz` times f and `acceleration_per_hz2` times f^2 are those at the frequency f.
    """

    angle_rad: Array
    velocity_per_hz: Array
    acceleration_per_hz2: Array

    @property
    def size(self) -> int:
        """The number of phases."""
        return len(self.angle_rad)


@lru_cache(maxsize=4)
def make_swing(ratio: float, size: int = GRID) -> Swing:
    """Return the swing of a guide bar of that eccentric ratio; cached."""
    phase = 2 * np.pi * np.arange(size) / size
    return Swing(
        swing_angle(phase, ratio),
        angular_velocity(phase, 1.0, ratio),
        angular_acceleration(phase, 1.0, ratio),
    )


def measured_ratio(points: Sequence[SwingPoint]) -> float:
    """Return the eccentric ratio that the angle channel shows, mean over the points.

    It is the amplitude of the angle's first harmonic: theta = sum (-1)^(k+1) lambda^k/k sin k phi.
    Raises DataError for no points: it is the no-load run that may be missing.
    """
    if not points:
        raise DataError("there is no no-load run", hint="record the no-load sweep first")
    return float(
        np.mean([-2 * np.fft.rfft(p.angle_rad)[1].imag / len(p.angle_rad) for p in points])
    )


def strokes(angle_rad: Array) -> tuple[Stroke, Stroke]:
    """Return the forward (rising) and the backward stroke of a periodic angle, shape (n,)."""
    size = len(angle_rad)
    lowest, highest = int(np.argmin(angle_rad)), int(np.argmax(angle_rad))
    twice = _two_turns(size)
    forward = twice[lowest : lowest + (highest - lowest) % size]
    backward = twice[highest : highest + (lowest - highest) % size]
    return (
        Stroke(forward, np.maximum.accumulate(angle_rad[forward] - angle_rad[lowest])),
        Stroke(backward, np.maximum.accumulate(angle_rad[highest] - angle_rad[backward])),
    )


@lru_cache(maxsize=4)
def _two_turns(size: int) -> NDArray[np.intp]:
    """Return the places of the samples of two turns: a stroke may go on past the last sample."""
    places = np.concatenate([np.arange(size), np.arange(size)])
    places.flags.writeable = False
    return places


def at_same_distance(values: Array, strokes_before: tuple[Stroke, Stroke], to_rad: Array) -> Array:
    """Return values that belong to one angle at another, by the way since the reversal.

    `values`, shape (n,), belong to the angle of `strokes_before`; `to_rad`, of the same shape, is a
    similar swing on the same phases. Beyond the end of a stroke its last value is kept.
    """
    result = np.empty_like(values)
    for before, after in zip(strokes_before, strokes(to_rad), strict=True):
        result[after.index] = np.interp(
            after.distance_rad, before.distance_rad, values[before.index]
        )
    return result


def interpolated(waveform: Array, size: int) -> Array:
    """Return periodic waveforms of shape (..., n) on `size` >= n phases, by their harmonics."""
    n = waveform.shape[-1]
    spectrum = np.fft.rfft(waveform, axis=-1) * (size / n)
    return np.fft.irfft(spectrum, size, axis=-1)


def running_torque(swing: Swing, torque_nm: Array) -> Array:
    """Return the work of swings of shape (..., n) over the way of a swing, in N·m.

    The sum over equal steps of phase is exact for periodic waveforms up to the harmonic n/2.
    """
    work = (torque_nm * swing.velocity_per_hz).mean(axis=-1)
    return np.asarray(work / np.abs(swing.velocity_per_hz).mean())


def inertia_in_phase(swing: Swing, torque_nm: Array) -> Array:
    """Return what of torques (..., n) follows the acceleration, over that at 1 Hz, in kg·m² (...,).

    Friction is even about the middle of the swing, and opposite in both strokes; the acceleration
    is neither. Away from the reversals, where friction no longer builds up.
    """
    middle = np.abs(swing.angle_rad) <= BUILT_UP * np.abs(swing.angle_rad).max()
    forward = swing.velocity_per_hz[middle] > 0
    basis = np.stack([forward, ~forward, swing.acceleration_per_hz2[middle]], axis=1)
    rows = torque_nm[..., middle].reshape(-1, len(basis))
    coefficient = np.linalg.lstsq(basis.astype(float), rows.T, rcond=None)[0][-1]
    return np.asarray(coefficient.reshape(torque_nm.shape[:-1]))


def spring_torque(swing: Swing, torque_nm: Array) -> float:
    """Return the torque at the swing's end of a spring that would explain the middle of it, N·m.

    There friction is even, and opposite in both strokes; what follows the angle is neither.
    """
    amplitude = np.abs(swing.angle_rad).max()
    middle = np.abs(swing.angle_rad) <= MIDDLE * amplitude
    forward = swing.velocity_per_hz[middle] > 0
    basis = np.stack([forward, ~forward, swing.angle_rad[middle] / amplitude], axis=1)
    return float(np.linalg.lstsq(basis.astype(float), torque_nm[middle], rcond=None)[0][-1])
