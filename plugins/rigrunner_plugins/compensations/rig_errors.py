"""What a budget says of the rig, put into a sweep as errors of its data, for Monte Carlo draws."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.analysis import SwingPoint
from rigrunner.signal import response

if TYPE_CHECKING:
    from numpy.random import Generator

    from rigrunner.api.analysis import PeakPoint, Sweep
    from rigrunner.api.data import Array
    from rigrunner_plugins.compensations.identification import Identified
    from rigrunner_plugins.compensations.settings import InverseSettings


@dataclass(frozen=True, eq=False)
class RigErrors:
    """Draws an inertia and a support's friction that changed under load, and a low-pass corner.

    Each is a rectangle of the half-width that the settings state. What changed at the load goes
    through the drive line as learned, and so into the loaded run's torque. The drive line itself is
    learned anew from each draw, and so has its own error.
    """

    settings: InverseSettings
    rig: Identified
    covers: tuple[str, ...] = (
        "resonance, damping, inertia",
        "low-pass filter",
        "inertia between the runs",
        "support friction under load",
    )

    def __call__(self, sweep: Sweep, rng: Generator) -> Sweep:
        """Return the sweep with one draw of these errors."""
        corner, inertia, friction = rng.uniform(-1, 1, 3)
        low_pass = sweep.instrument.low_pass
        assert low_pass is not None  # noqa: S101  (the rig was learned with it)
        filtered = low_pass.scaled(float(1 + self.settings.low_pass_tolerance * corner))
        instrument = sweep.instrument.model_copy(update={"low_pass": filtered})
        mismatch = self.settings.inertia_mismatch * inertia * self.rig.line.inertia_kgm2
        growth = self.settings.support_load_dependence * friction
        loaded = tuple(self._changed(point, mismatch, growth) for point in sweep.loaded)
        return replace(sweep, loaded=loaded, instrument=instrument)

    def _changed(self, point: PeakPoint, mismatch_kgm2: float, growth: float) -> PeakPoint:
        if not isinstance(point, SwingPoint):
            return point
        frequency = point.frequency_hz.value
        friction = self.rig.friction
        accelerated = mismatch_kgm2 * friction.swing.acceleration_per_hz2 * frequency**2
        at_load = accelerated + growth * friction.dry_nm
        seen = self._at_sensor(at_load, frequency)
        step = len(seen) // point.torque_nm.shape[1]
        return replace(point, torque_nm=point.torque_nm + seen[::step])

    def _at_sensor(self, torque_nm: Array, frequency_hz: float) -> Array:
        """Return what the sensor shows of a torque on the inertia, one swing of shape (n,)."""
        harmonic_hz = frequency_hz * np.arange(len(torque_nm) // 2 + 1, dtype=np.float64)
        return response.apply(self.rig.line.sensor(harmonic_hz), torque_nm)
