"""Raw peak minus the raw no-load peak of the same frequency: Eq. (2) without the fitted curve.

What Wang et al. (Machines 2025, 13(11), 976) do, but for the fit of Eq. (1): the misfit of a curve
is not in it, and that the two peaks stand at different phases still is.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, sqrt
from typing import TYPE_CHECKING

from rigrunner.api import Estimate
from rigrunner.signal.inputs import model_of
from rigrunner.signal.transducer import transducer_effects
from rigrunner_bearings.api.compensations import Compensation
from rigrunner_bearings.compensations import checks
from rigrunner_bearings.compensations.limits import load
from rigrunner_bearings.compensations.matching import pairs
from rigrunner_bearings.compensations.peak_budget import frequency_effect, notes_on, scattered_peaks
from rigrunner_bearings.signal.compensated import compensated_point
from rigrunner_bearings.signal.peaks import mean_peak, scatter_effect
from rigrunner_bearings.signal.sensor import difference_effects, gain

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Effect
    from rigrunner_bearings.api.compensations import CompensatedPoint, Sweep
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.compensations.settings import PeakSameFrequencySettings

MEASURAND = "starting torque as the difference of raw peaks of the same frequency"
APART = 0.05
"""Least relative distance of two points that show a slope."""


@dataclass(frozen=True)
class PeakSameFrequency:
    """The compensation `peak_same_frequency`."""

    settings: PeakSameFrequencySettings

    def __call__(self, sweep: Sweep) -> Compensation:
        """Return the difference per set-point; DataError for one without no-load partner."""
        matched = pairs(sweep.loaded, sweep.no_load, self.settings.frequency_match)
        points = tuple(_point(sweep, *pair) for pair in matched)
        return Compensation(
            MEASURAND,
            points,
            checks=(
                checks.independent_cycles(points, [scattered_peaks(*pair) for pair in matched]),
            ),
            notes=notes_on((*sweep.loaded, *sweep.no_load)),
        )


def _point(sweep: Sweep, loaded: PeakPoint, no_load: PeakPoint) -> CompensatedPoint:
    raw, rig = mean_peak(loaded), mean_peak(no_load)
    effects = (
        scatter_effect("scatter between cycles, loaded", raw),
        scatter_effect("scatter between cycles, no load", rig),
        _frequency(loaded, no_load, sweep.no_load),
        *difference_effects(sweep.instrument, runs=2),
        *transducer_effects(
            sweep.instrument, raw.value - rig.value, (raw.value, rig.value), slow=sqrt(2)
        ),
    )
    scales = (gain(sweep.instrument), load(sweep.rig))
    return compensated_point(
        model_of(raw.value - rig.value, effects, scales=scales),
        set_frequency_hz=loaded.set_frequency_hz,
        frequency_hz=loaded.frequency_hz.value,
        raw_nm=raw.value,
    )


def _frequency(loaded: PeakPoint, no_load: PeakPoint, others: Sequence[PeakPoint]) -> Effect:
    """Return the effect on the peak of the two frequencies not being the same.

    Each has its own uncertainty, and what they are seen to differ by is not corrected.
    """
    estimates = loaded.frequency_hz, no_load.frequency_hz
    difference = (estimates[0].value - estimates[1].value) / sqrt(3)
    u = hypot(estimates[0].u, estimates[1].u, difference)
    dof = min(estimate.dof for estimate in estimates)
    return frequency_effect(_slope(no_load, others), Estimate(0.0, u, dof, "Hz"))


def _slope(point: PeakPoint, others: Sequence[PeakPoint]) -> float:
    """Return how steeply the no-load peak goes with frequency, in N·m/Hz.

    From the neighbour in frequency; of a single point, what inertia alone would make: 2 T/f.
    """
    peak_nm, hertz = mean_peak(point).value, point.frequency_hz.value
    distant = [other for other in others if abs(other.frequency_hz.value - hertz) > APART * hertz]
    if not distant:
        return 2 * peak_nm / hertz
    neighbour = min(distant, key=lambda other: abs(other.frequency_hz.value - hertz))
    return (mean_peak(neighbour).value - peak_nm) / (neighbour.frequency_hz.value - hertz)
