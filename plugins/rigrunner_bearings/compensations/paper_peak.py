"""The published method: mean raw peak minus the fitted no-load peak, Eq. (1), (2) of Wang et al.

Machines 2025, 13(11), 976, doi:10.3390/machines13110976: Td = Tc - Tg(f). Kept as it was
published, for comparison: with load the peak falls near the reversal, without load later in the
stroke, and maxima at two phases have no difference that means a torque.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING, Final

import numpy as np

from rigrunner.api import DataError, Distribution, Effect, Input, Points, Spreading
from rigrunner.api.uncertainty import Line
from rigrunner.signal.inputs import model_of
from rigrunner.signal.transducer import transducer_effects
from rigrunner_bearings.api.compensations import Compensation
from rigrunner_bearings.compensations import checks
from rigrunner_bearings.compensations.limits import load
from rigrunner_bearings.compensations.peak_budget import frequency_effect, notes_on, scattered_peaks
from rigrunner_bearings.signal.compensated import compensated_point
from rigrunner_bearings.signal.peaks import mean_peak, peak_points, scatter_effect
from rigrunner_bearings.signal.sensor import difference_effects, gain
from rigrunner_plugins.fits.curve import r_squared
from rigrunner_plugins.fits.polynomial import PolynomialFit
from rigrunner_plugins.fits.settings import PolynomialSettings

if TYPE_CHECKING:
    from rigrunner.api import Array, Curve
    from rigrunner_bearings.api.compensations import CompensatedPoint, Sweep
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.compensations.settings import PaperPeakSettings
    from rigrunner_plugins.fits.curve import FittedCurve


MEASURAND = "starting torque as the difference of raw peaks (Eq. 2 of the paper)"
FIT = "no-load fit"
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
        points = tuple(self._point(point, curve, sweep) for point in sweep.loaded)
        return Compensation(
            measurand=MEASURAND,
            points=points,
            checks=(checks.independent_cycles(points, [scattered_peaks(p) for p in sweep.loaded]),),
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

    def _point(self, point: PeakPoint, curve: Curve, sweep: Sweep) -> CompensatedPoint:
        frequency = point.frequency_hz.value
        peak = mean_peak(point)
        value, fit = _rig_part(curve, frequency)
        readings = (peak.value, value) if self._refit else (peak.value,)
        effects = (
            scatter_effect("scatter between cycles", peak),
            *fit,
            frequency_effect(_slope(curve, frequency), point.frequency_hz),
            *difference_effects(sweep.instrument, runs=len(readings)),
            *transducer_effects(
                sweep.instrument, peak.value - value, readings, slow=sqrt(len(readings))
            ),
            # Refitted, both peaks come from the sensor, and its gain scales their difference.
            *(() if self._refit else (Effect(gain(sweep.instrument), -peak.value),)),
        )
        scales = (gain(sweep.instrument),) if self._refit else ()
        model = model_of(
            peak.value - value,
            effects,
            scales=(*scales, load(sweep.rig)),
            lines={FIT: Line(value, -1.0)},
        )
        return compensated_point(
            model,
            set_frequency_hz=point.set_frequency_hz,
            frequency_hz=frequency,
            raw_nm=peak.value,
        )


def _slope(curve: Curve, frequency_hz: float) -> float:
    """Return how steeply the curve goes with frequency, in N·m/Hz, within its range."""
    low, high = curve.valid_x
    around = np.clip(frequency_hz * (1 + np.array([-STEP, STEP])), low, high)
    values, _ = curve.predict(around)
    return float(np.ptp(values) / np.ptp(around)) if np.ptp(around) > 0 else 0.0


def _rig_part(curve: Curve, frequency_hz: float) -> tuple[float, tuple[Effect, ...]]:
    """Return the curve's value in N·m and its uncertainty, its covariance whole.

    In directions in which the coefficients are independent of each other, each of them common to
    all points: so the covariance between two frequencies is carried too.
    """
    at_hz = np.array([frequency_hz])
    value, u = curve.predict(at_hz)
    spread = curve.spread(at_hz)[0] if isinstance(curve, Spreading) else u
    directions = [
        Input(
            f"{FIT}, direction {number}",
            0.0,
            1.0,
            curve.dof,
            Distribution.T,
            "1",
            common=True,
            line=FIT,
            ensemble=FIT,
        )
        for number in range(1, len(spread) + 1)
    ]
    return float(value[0]), tuple(
        Effect(direction, -float(row)) for direction, row in zip(directions, spread, strict=True)
    )


TABLE_2_HZ: Final = (1.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0)
TABLE_2_NM: Final = (0.83, 1.21, 1.64, 2.32, 3.01, 3.96, 5.12, 6.91)
PUBLISHED: Final = (0.9173, 0.0247, 0.0041)
"""Tg = 0.0041 f^2 + 0.0247 f + 0.9173 in N·m with f in Hz, for 1 Hz to 35 Hz."""


def published_curve() -> FittedCurve:
    """Return Eq. (1) as printed, rounded, with the covariance of the fit that it came from.

    The paper states no uncertainty; ordinary least squares of its Table 2 gives its coefficients
    to the printed digits, and with them their covariance.
    """
    points = Points(np.array(TABLE_2_HZ), np.array(TABLE_2_NM))
    fit = PolynomialFit(PolynomialSettings(degree=2))(points)
    coefficients = np.array(PUBLISHED)
    residuals = points.y - _value(points.x)

    def value_and_spread(x: Array) -> tuple[Array, Array]:
        return _value(x), fit.value_and_spread(x)[1]

    return replace(
        fit,
        coefficients=coefficients,
        residuals=residuals,
        residual_s=float(np.sqrt(np.sum(residuals**2) / fit.dof)),
        r_squared=r_squared(points.y, residuals),
        value_and_spread=value_and_spread,
    )


def _value(frequency_hz: Array) -> Array:
    powers = frequency_hz[:, None] ** np.arange(len(PUBLISHED))
    value: Array = powers @ np.array(PUBLISHED)
    return value
