"""A budget's errors of the rig, added to the data of a sweep for Monte Carlo draws."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Distribution
from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.compensations import response

if TYPE_CHECKING:
    from numpy.random import Generator

    from rigrunner.api import Input
    from rigrunner_bearings.api.compensations import Sweep
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.compensations.identification import Identified
    from rigrunner_bearings.compensations.limits import SupportGrowth
    from rigrunner_bearings.compensations.settings import InverseSettings


@dataclass(frozen=True, eq=False)
class RigErrors:
    """Draws a support's friction that changed under load or in between, and a low-pass corner.

    Each within the half-width that the settings state. What changed at the load goes
    through the drive line as learned, and so into the loaded run's torque. The drive line itself is
    learned again from each draw, and so has its own error.
    """

    settings: InverseSettings
    support: SupportGrowth
    rig: Identified
    drift: Input | None = None
    """Of the support's dry friction from one run to the other, a part of it."""

    @property
    def covers(self) -> tuple[str, ...]:
        """The lines of the budget that are drawn."""
        drawn = ["resonance, damping, inertia", "low-pass filter"]
        if not self.support.measured:
            drawn.append(self.support.name)
        if self.drift is not None:
            drawn.append(self.drift.name)
        return tuple(drawn)

    def __call__(self, sweep: Sweep, rng: Generator) -> Sweep:
        """Return the sweep with one draw of these errors."""
        corner, friction = rng.uniform(-1, 1, 2)
        low_pass = sweep.instrument.low_pass
        assert low_pass is not None  # noqa: S101  (the rig was learned with it)
        filtered = low_pass.scaled(float(1 + self.settings.low_pass_tolerance * corner))
        instrument = sweep.instrument.model_copy(update={"low_pass": filtered})
        growth, drift = self.support.limit * friction, _drawn(self.drift, rng)
        loaded = tuple(
            self._changed(point, growth * share + drift)
            for point, share in zip(sweep.loaded, self.support.at_points, strict=True)
        )
        return replace(sweep, loaded=loaded, instrument=instrument)

    def _changed(self, point: PeakPoint, growth: float) -> PeakPoint:
        if not isinstance(point, SwingPoint):
            return point
        torque_nm = growth * self.rig.friction.dry_nm
        harmonics = np.arange(len(torque_nm) // 2 + 1, dtype=np.float64)
        at_sensor = self.rig.line.sensor(point.frequency_hz.value * harmonics)
        sensor_nm = response.apply(at_sensor, torque_nm)
        step = len(sensor_nm) // point.torque_nm.shape[1]
        return replace(point, torque_nm=point.torque_nm + sensor_nm[::step])


def _drawn(error: Input | None, rng: Generator) -> float:
    if error is None:
        return 0.0
    if error.distribution is Distribution.TRIANGULAR:
        limit = error.u * sqrt(6)
        return float(rng.triangular(-limit, 0.0, limit))
    limit = error.u * sqrt(3)
    return float(rng.uniform(-limit, limit))
