"""One draw of the recorded data: other cycles, and a sensor with other errors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.signal.monte_carlo.distributions import named
from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.signal.sensor import stated

if TYPE_CHECKING:
    from numpy.random import Generator

    from rigrunner.api import Array, Instrument, Mask
    from rigrunner_bearings.api.compensations import Sweep
    from rigrunner_bearings.api.points import PeakPoint

PARABOLA = 4.0
"""Of an error curve e(x) = 4 a x (1 - x): its greatest value is a, at half of full scale."""


@dataclass(frozen=True)
class Sensor:
    """One transducer out of all that the register allows, by the errors' distributions."""

    gain: float
    """Of the reading."""
    nonlinearity: float
    """The greatest value of its error curve, a parabola that is odd in torque, of full scale."""
    full_scale_nm: float
    offset_nm: float

    @classmethod
    def drawn(cls, instrument: Instrument, rng: Generator, *, zeroed: bool) -> Sensor:
        """Return one that is the same in both runs; a zero step takes the offset out."""
        full_scale = instrument.full_scale
        return cls(
            gain=_error(instrument, "gain", rng),
            nonlinearity=_error(instrument, "nonlinearity", rng) / full_scale,
            full_scale_nm=full_scale,
            offset_nm=0.0 if zeroed else _error(instrument, "offset", rng),
        )

    def reads(self, torque_nm: Array) -> Array:
        """Return what it shows of a torque, any shape."""
        share = np.abs(torque_nm) / self.full_scale_nm
        curved = PARABOLA * self.nonlinearity * (1 - share)
        return np.asarray(torque_nm * (1 + self.gain + curved) + self.offset_nm)


@dataclass(frozen=True)
class Drift:
    """Drift of the zero of one run: constant over the run, and within each recording."""

    constant_nm: float
    course_nm: float

    @classmethod
    def drawn(cls, instrument: Instrument, rng: Generator) -> Drift:
        """Return one within the register's limits."""
        return cls(_error(instrument, "drift", rng), _error(instrument, "drift", rng))

    def at(self, turns: Array, cycles: int) -> Array:
        """Return the zero at crank turns since the recording began, any shape, in N·m."""
        return np.asarray(self.constant_nm + self.course_nm * (turns / cycles - 0.5))


def _error(instrument: Instrument, name: str, rng: Generator) -> float:
    """Return one draw of an error that the register states."""
    error = stated(instrument, name, name)
    return float(named(error.distribution, 0.0, error.u).draw(rng, 1)[0])


def another_sensor(sweep: Sweep, rng: Generator, *, zeroed: bool) -> Sweep:
    """Return the sweep as another transducer of the same register would have shown it."""
    sensor = Sensor.drawn(sweep.instrument, rng, zeroed=zeroed)
    drifts = Drift.drawn(sweep.instrument, rng), Drift.drawn(sweep.instrument, rng)
    loaded, no_load = (
        tuple(_indicated(point, sensor, drift) for point in points)
        for points, drift in zip((sweep.loaded, sweep.no_load), drifts, strict=True)
    )
    return replace(sweep, loaded=loaded, no_load=no_load)


def _indicated(point: PeakPoint, sensor: Sensor, drift: Drift) -> PeakPoint:
    turns = np.arange(point.cycles, dtype=np.float64)
    peaks = sensor.reads(point.peak_nm) + drift.at(turns + 0.5, point.cycles)
    if not isinstance(point, SwingPoint):
        return replace(point, peak_nm=peaks)
    rows, phases = point.torque_nm.shape
    first = np.linspace(0, point.cycles, rows, endpoint=False)  # a row may be a mean of several
    within = first[:, None] + np.linspace(0, 1, phases, endpoint=False)
    torque = sensor.reads(point.torque_nm) + drift.at(within, point.cycles)
    return replace(point, peak_nm=peaks, torque_nm=torque)


def other_cycles(sweep: Sweep, rng: Generator) -> Sweep:
    """Return the sweep with the kept cycles of each recording drawn again, with replacement.

    Their deviations from the mean are widened by sqrt(n/(n - 1)), so that the mean of a draw has
    the variance s^2/n of a type A evaluation (JCGM 100, 4.2.3).
    """
    loaded, no_load = (
        tuple(_redrawn(point, rng) for point in points) for points in (sweep.loaded, sweep.no_load)
    )
    return replace(sweep, loaded=loaded, no_load=no_load)


def _redrawn(point: PeakPoint, rng: Generator) -> PeakPoint:
    peaks = _drawn(point.peak_nm, point.peak_kept, rng)
    changed = replace(point, peak_nm=peaks, peak_kept=np.ones(len(peaks), bool))
    if not isinstance(changed, SwingPoint):
        return changed
    torque = _drawn(changed.torque_nm, changed.kept, rng)
    return replace(changed, torque_nm=torque, kept=np.ones(len(torque), bool))


def _drawn(values: Array, kept: Mask, rng: Generator) -> Array:
    """Return as many rows as are kept, drawn from these."""
    rows = values[kept]
    n = len(rows)
    if n == 1:
        return rows
    mean = rows.mean(axis=0)
    redrawn = rows[rng.integers(n, size=n)]
    return np.asarray(mean + sqrt(n / (n - 1)) * (redrawn - mean))
