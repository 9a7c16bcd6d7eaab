"""Running torque from the work of one swing: what the bearing takes up over the way it goes.

T = W / (4 Theta): W is the loop integral of the torque over the angle, loaded minus no-load, and
4 Theta the way of one swing. Forces that store and give back (inertia, spring) do no work over a
whole swing, so no drive line need be known; but this is the mean torque under way, not the starting
torque.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Effect
from rigrunner.signal.averaging import mean_and_without_each
from rigrunner.signal.inputs import model_of, scattered
from rigrunner.signal.repeatability import influences, jackknife_error
from rigrunner.signal.transducer import transducer_effects
from rigrunner_bearings.api.compensations import Compensation, Trace
from rigrunner_bearings.compensations import checks
from rigrunner_bearings.compensations.limits import load, support_drift, support_growth
from rigrunner_bearings.compensations.matching import pairs
from rigrunner_bearings.compensations.swing import make_swing, measured_ratio, running_torque
from rigrunner_bearings.signal.compensated import compensated_point
from rigrunner_bearings.signal.sensor import curve_slope, gain, one_figure, stated
from rigrunner_bearings.signal.swings import kept_cycles, with_swings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Array
    from rigrunner_bearings.api.compensations import CompensatedPoint, Sweep
    from rigrunner_bearings.api.points import SwingPoint
    from rigrunner_bearings.compensations.limits import SupportGrowth
    from rigrunner_bearings.compensations.settings import EnergySettings

MEASURAND = "load-induced running torque, mean over the swing"
SLOW, LEAST_SPAN = 1 / 3, 0.1
"""Of the highest frequency: which set-points are slow. Of that: what a line has to span."""
NOTES = ("The mean torque under way, not the starting torque: it has no peak in it.",)


@dataclass(frozen=True)
class Energy:
    """The compensation `energy`."""

    settings: EnergySettings

    def __call__(self, sweep: Sweep) -> Compensation:
        """Return the running torque per frequency.

        Raises DataError for a point without whole swings and one without no-load partner.
        """
        sweep = with_swings(sweep)
        matched = pairs(sweep.loaded, sweep.no_load, self.settings.frequency_match)
        ratio = measured_ratio((*sweep.loaded, *sweep.no_load))
        dry_nm = _dry_nm(sweep.no_load, ratio)
        support = support_growth(self.settings, sweep)
        results = [
            self._point(sweep, ratio, *pair, dry_nm=dry_nm, support=support, share=share)
            for share, pair in zip(support.at_points, matched, strict=True)
        ]
        points = tuple(point for point, _ in results)
        scattered_nm = [[influences(run) for run in without_each] for _, without_each in results]
        energy_checks = (
            checks.independent_cycles(points, scattered_nm),
            checks.positive(points, [point.torque.value for point in points]),
        )
        return Compensation(MEASURAND, points, checks=energy_checks, notes=NOTES)

    def _point(
        self,
        sweep: Sweep,
        ratio: float,
        loaded: SwingPoint,
        no_load: SwingPoint,
        *,
        dry_nm: float,
        support: SupportGrowth,
        share: float,
    ) -> tuple[CompensatedPoint, list[Array]]:
        """Return the point, and the torques of both runs without each of their cycles.

        `dry_nm` is the dry part of the running torque without load, `share` that of the support's
        growth at this point.
        """
        swing = make_swing(ratio, loaded.torque_nm.shape[-1])
        runs = [mean_and_without_each(run.torque_nm, run.kept) for run in (loaded, no_load)]
        means = [mean for mean, _ in runs]
        without_each = [running_torque(swing, replicates) for _, replicates in runs]
        readings = [float(np.abs(mean).max()) for mean in means]
        raw, unloaded = (float(running_torque(swing, mean)) for mean in means)
        rig = unloaded + support.growth * share * dry_nm
        drift = support_drift(self.settings, sweep)
        effects = (
            scattered("repeatability, loaded", *jackknife_error(without_each[0])),
            scattered("repeatability, no load", *jackknife_error(without_each[1])),
            curve_slope(sweep.instrument, raw - rig),
            # An offset does no work over a swing.
            Effect(stated(sweep.instrument, "offset", "sensor offset"), 0.0),
            *one_figure(sweep.instrument),
            support.effect(dry_nm, share),
            *(() if drift is None else (Effect(drift, -dry_nm),)),
            *transducer_effects(sweep.instrument, raw - rig, readings, slow=0.0),
        )
        scales = (gain(sweep.instrument), load(sweep.rig))
        point = compensated_point(
            model_of(raw - rig, effects, scales=scales),
            set_frequency_hz=loaded.set_frequency_hz,
            frequency_hz=loaded.frequency_hz.value,
            raw_nm=raw,
            trace=Trace(loaded.angle_rad, means[0], means[1], means[0] - means[1]),
            cycles_used=int(kept_cycles(loaded).sum()),
        )
        return point, without_each


def _dry_nm(no_load: Sequence[SwingPoint], ratio: float) -> float:
    """Return the dry part of the running torque without load: what is left of it at no speed.

    A straight line over the frequency, for friction in proportion to speed does work in proportion
    to it; of the slow set-points, for the fast ones twist the drive line. Where there is but one of
    them, the torque there. Dry friction is what a load raises; that of a lubricant depends on speed
    alone (M0 of Palmgren's model, as in ISO 15312).
    """
    slow_hz = SLOW * max(point.frequency_hz.value for point in no_load)
    slowest = min(no_load, key=lambda point: point.frequency_hz.value)
    slow = [point for point in no_load if point is slowest or point.frequency_hz.value <= slow_hz]
    frequencies = np.array([point.frequency_hz.value for point in slow])
    means = [mean_and_without_each(point.torque_nm, point.kept)[0] for point in slow]
    torques = [float(running_torque(make_swing(ratio, len(mean)), mean)) for mean in means]
    if np.ptp(frequencies) < LEAST_SPAN * slow_hz:
        return torques[int(frequencies.argmin())]
    line = np.polynomial.polynomial.polyfit(frequencies, torques, 1)
    return float(np.clip(line[0], 0.0, max(torques)))
