"""What too low a sample rate moves a torque by: found by the method, with half as many samples.

What is lost between the samples grows at least in proportion to their distance. So a method that is
run again with every swing sampled half as often moves by at least as much as what it has lost
already (GUM 5.1.3: a sensitivity found by trial).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import scipy

from rigrunner.api import DataError
from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.signal.cycles import SPLINE_ORDER

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.api.compensations import Compensation, CompensationMethod, Sweep
    from rigrunner_bearings.api.points import PeakPoint

ENOUGH = 280.0
"""Samples in a cycle: twelve for each of the harmonics that a method undoes the drive line of."""


def with_half_the_samples(
    method: CompensationMethod, sweep: Sweep, compensation: Compensation
) -> tuple[float, ...]:
    """Return what each torque moves by; nothing where all cycles have samples enough.

    All of itself, where half of them give no result.
    """
    swings = [p for p in (*sweep.loaded, *sweep.no_load) if isinstance(p, SwingPoint)]
    if not swings or not compensation.points or min(map(samples_per_cycle, swings)) >= ENOUGH:
        return ()
    fewer = replace(
        sweep, loaded=tuple(map(_halved, sweep.loaded)), no_load=tuple(map(_halved, sweep.no_load))
    )
    try:
        points = method(fewer).points
    except DataError:
        return tuple(-point.torque.value for point in compensation.points)
    return tuple(
        after.torque.value - before.torque.value
        for before, after in zip(compensation.points, points, strict=True)
    )


def samples_per_cycle(point: SwingPoint) -> float:
    """Return how many samples a cycle has."""
    return point.sample_rate_hz / point.frequency_hz.value


def _halved(point: PeakPoint) -> PeakPoint:
    if not isinstance(point, SwingPoint):
        return point
    count = round(samples_per_cycle(point) / 2)
    return replace(point, torque_nm=_sampled(point.torque_nm, count))


def _sampled(rows: Array, count: int) -> Array:
    """Return periodic rows of shape (cycles, n) by the spline through `count` samples of each."""
    size = rows.shape[1]
    if count >= size:
        return rows
    spectrum = np.fft.rfft(rows, axis=1)
    turn = np.exp(2j * np.pi * np.outer(np.arange(spectrum.shape[1]), np.arange(count) / count))
    # All but the first and the last coefficient of a real waveform count twice.
    weight = np.full(spectrum.shape[1], 2.0)
    weight[0] = weight[-1] = 1.0
    samples = ((spectrum * weight) @ turn).real / size
    position = np.arange(size) * count / size
    return np.array(
        [
            scipy.ndimage.map_coordinates(row, position[None], order=SPLINE_ORDER, mode="grid-wrap")
            for row in samples
        ]
    )
