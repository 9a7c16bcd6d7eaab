"""The published method: mean raw peak minus the fitted no-load peak, Eq. (2) of Wang et al.

Machines 2025, 13(11), 976, doi:10.3390/machines13110976: Td = Tc - Tg(f). Kept as it was
published, for comparison: with load the peak falls near the reversal, without load later in the
stroke, and maxima at two phases have no difference that means a torque.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.analysis import CompensatedPoint, Compensation, Component
from rigrunner.api.data import Estimate
from rigrunner.api.errors import DataError
from rigrunner.signal.peaks import mean_peak, peak_points
from rigrunner.signal.sensor import rectangular
from rigrunner.signal.uncertainty import combine
from rigrunner_plugins.compensations.paper_equation import published_curve

if TYPE_CHECKING:
    from rigrunner.api.analysis import Curve, PeakPoint, Sweep
    from rigrunner.api.instruments import TorqueInstrument
    from rigrunner_plugins.compensations.paper_peak_settings import PaperPeakSettings

MEASURAND = "starting torque as the difference of raw peaks (Eq. 2 of the paper)"
SAME_PHASE = (
    "Assumes that the loaded and the no-load peak fall at the same phase of the swing. They do "
    "not, so the result drifts with frequency; the uncertainty does not include this."
)
NOISY_MAXIMUM = "The maximum of noisy samples is high by the noise's extreme value."
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
        notes = (SAME_PHASE, NOISY_MAXIMUM)
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
        components = (scatter, fit, *self._sensor(instrument, raw, raw - rig))
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
        """Return what the sensor contributes.

        Refitted, both peaks come from the same sensor: its gain acts on their difference, and each
        run has drifted on its own since its zero reading. The zero takes the offset out.
        """
        accuracy = instrument.accuracy
        gain_acts_on, runs = (difference_nm, 2) if self._refit else (raw_nm, 1)
        drift = rectangular("zero drift", accuracy.drift)
        return (
            rectangular("sensor gain", accuracy.gain * gain_acts_on),
            rectangular("sensor non-linearity", accuracy.nonlinearity * instrument.full_scale),
            replace(drift, u=drift.u * sqrt(runs)),
        )


def _rig_part(curve: Curve, frequency_hz: float) -> tuple[float, Component]:
    """Return the curve's value in N·m and its uncertainty, its covariance whole, as one line."""
    value, u = curve.predict(np.array([frequency_hz]))
    return float(value[0]), Component("no-load fit", float(u[0]), curve.dof, "t", common=True)
