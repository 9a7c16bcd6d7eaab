"""The published method: mean raw peak minus the fitted no-load peak, Eq. (2) of Wang et al.

Machines 2025, 13(11), 976, doi:10.3390/machines13110976: Td = Tc - Tg(f). Kept as it was
published, for comparison: with load the peak falls near the reversal, without load later in the
stroke, and maxima at two phases have no difference that means a torque.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.analysis import CompensatedPoint, Compensation, Component
from rigrunner.api.data import Estimate
from rigrunner.api.errors import DataError
from rigrunner.signal.peaks import mean_peak, peak_points
from rigrunner.signal.uncertainty import combine
from rigrunner_plugins.compensations.paper_equation import published_curve
from rigrunner_plugins.compensations.peak_budget import (
    frequency_component,
    notes_on,
    sensor_components,
)

if TYPE_CHECKING:
    from rigrunner.api.analysis import Curve, PeakPoint, Sweep
    from rigrunner.api.instruments import TorqueInstrument
    from rigrunner_plugins.compensations.paper_peak_settings import PaperPeakSettings

MEASURAND = "starting torque as the difference of raw peaks (Eq. 2 of the paper)"
STEP = 1e-3
"""Relative distance over which the curve's slope is taken."""
OTHER_RIG = (
    "The published coefficients describe the authors' rig. How far this rig differs from it is not "
    "in the uncertainty."
)


@dataclass(frozen=True)
class PaperPeak:
    """Eq. (2); satisfies `rigrunner.api.analysis.CompensationMethod`."""

    settings: PaperPeakSettings

    def __call__(self, sweep: Sweep) -> Compensation:
        """Return torque per set-point; raise DataError without a no-load run or out of range."""
        curve = self._curve(sweep)
        notes = notes_on((*sweep.loaded, *sweep.no_load) if self._refit else sweep.loaded)
        return Compensation(
            measurand=MEASURAND,
            points=tuple(self._point(point, curve, sweep.instrument) for point in sweep.loaded),
            curve=curve,
            notes=notes if self._refit else (*notes, OTHER_RIG),
        )

    @property
    def _refit(self) -> bool:
        return self.settings.coefficients == "refit"

    def _curve(self, sweep: Sweep) -> Curve:
        if not self._refit:
            return published_curve()
        if not sweep.no_load:
            raise DataError(
                "paper_peak needs a no-load run to refit its coefficients",
                hint="record one, or set coefficients: published",
            )
        return sweep.fit(peak_points(sweep.no_load))

    def _point(
        self, point: PeakPoint, curve: Curve, instrument: TorqueInstrument
    ) -> CompensatedPoint:
        frequency = point.frequency_hz.value
        raw, scatter = mean_peak(point)
        rig, fit = _rig_part(curve, frequency)
        components = (
            *scatter,
            fit,
            frequency_component(_slope(curve, frequency), point.frequency_hz),
            *self._sensor(instrument, raw, raw - rig),
        )
        u, dof = combine(components)
        return CompensatedPoint(
            set_frequency_hz=point.set_frequency_hz,
            frequency_hz=frequency,
            raw_nm=raw,
            rig_nm=rig,
            torque=Estimate(raw - rig, u, dof),
            components=components,
        )

    def _sensor(
        self, instrument: TorqueInstrument, raw_nm: float, difference_nm: float
    ) -> tuple[Component, ...]:
        """Return the sensor's part: refitted, both peaks come from it and its gain acts alike."""
        if self._refit:
            return sensor_components(instrument, difference_nm, runs=2)
        return sensor_components(instrument, raw_nm, runs=1)


def _slope(curve: Curve, frequency_hz: float) -> float:
    """Return how steeply the curve goes with frequency, in N·m/Hz, within its range."""
    low, high = curve.valid_x
    around = np.clip(frequency_hz * (1 + np.array([-STEP, STEP])), low, high)
    values, _ = curve.predict(around)
    return float(np.ptp(values) / np.ptp(around)) if np.ptp(around) > 0 else 0.0


def _rig_part(curve: Curve, frequency_hz: float) -> tuple[float, Component]:
    """Return the curve's value in N·m and its uncertainty, its covariance whole, as one line."""
    value, u = curve.predict(np.array([frequency_hz]))
    return float(value[0]), Component("no-load fit", float(u[0]), curve.dof, "t", common=True)
