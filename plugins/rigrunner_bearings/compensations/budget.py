"""The measurement model of a starting torque from whole swings, and what its inputs are worth.

    T = (T_d + sum c_i (x_i - estimate_i)) / ((1 + gain) (1 + load))

T_d is the result of the algorithm for the two runs at the best estimates. Each c_i is its change
with x_i: found by trial through the algorithm itself (GUM 5.1.3, note 2), or by its equation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Distribution, Effect, Input
from rigrunner.api.uncertainty import Line
from rigrunner.signal.inputs import bounded_effect, limited, model_of, scattered
from rigrunner.signal.repeatability import jackknife_error
from rigrunner.signal.transducer import transducer_effects
from rigrunner_bearings.compensations.bearing import starting_torque
from rigrunner_bearings.compensations.comparison import LINE as BETWEEN
from rigrunner_bearings.compensations.filters import corner_hz
from rigrunner_bearings.compensations.identification import Identified, vector, with_vector
from rigrunner_bearings.compensations.limits import load
from rigrunner_bearings.signal.sensor import curve_slope, gain, one_figure, stated

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Instrument, MeasurementModel
    from rigrunner_bearings.api.rig import RigDescription
    from rigrunner_bearings.compensations.bearing import MeanSwing, Pair
    from rigrunner_bearings.compensations.drive_line import DriveLine
    from rigrunner_bearings.compensations.evaluation import Evaluation
    from rigrunner_bearings.compensations.settings import InverseSettings

PLACE = 0.1
"""Of what the friction's place makes out: more than either rig model errs by, without noise."""

COARSER = 0.8
"""Of the harmonics: what changes with a fifth fewer of them is not resolved. On rigs of both models
without noise, of 200 Hz to 800 Hz, the change is as large as the error."""

LEARNED = "resonance, damping, inertia"
LEARNED_UNITS = {
    "natural frequency": "Hz",
    "damping ratio": "1",
    "inertia": "kg·m²",
    "share of twist in friction": "1",
    "delay of torque behind angle": "s",
}
"""Names and units of what is learned from the no-load sweep, in the order of its covariance."""


@dataclass(frozen=True, eq=False)
class Budget:
    """Makes the measurement model of every point of a sweep.

    The settings' limits are those of this very rig, where its station states them.

    `refiltered` is the rig as learned with the low-pass corner at its upper limit, `rescaled` the
    same with the angle's scale at its.
    """

    settings: InverseSettings
    instrument: Instrument
    described: RigDescription
    rig: Identified
    refiltered: Identified
    rescaled: Identified

    def model(
        self, evaluation: Evaluation, between: Sequence[Effect], support_nm: float
    ) -> MeasurementModel:
        """Return the model of one point; `between` is what the two runs may still differ by.

        `support_nm` is what the load is known to add to the support's friction.
        """
        pair, line = evaluation.pair, self.rig.line
        corner, angle_limit = corner_hz(line.low_pass), self.described.angle_tolerance
        corner_limit = corner_hz(self.refiltered.line.low_pass) - corner
        low_pass = limited("low-pass filter", corner_limit, "Hz", corner)
        coarser = replace(line, harmonics=round(COARSER * line.harmonics))
        unresolved = self._torque(coarser, pair) - evaluation.maximum_nm
        u = np.sqrt(np.diag(self.rig.covariance))
        effects = (
            _repeatability("repeatability, loaded", evaluation, 0),
            _repeatability("repeatability, no load", evaluation, 1),
            bounded_effect("noise in the maximum", evaluation.bias_nm),
            *self._sensor(evaluation),
            *self._drive_line(pair),
            Effect(low_pass, self._slope(self.refiltered, corner_limit, evaluation)),
            # What a swing larger than the angle channel shows does: J is learned again.
            Effect(
                limited("angle scale", angle_limit, "1"),
                self._slope(self.rescaled, angle_limit, evaluation),
            ),
            # The difference of the two frequencies is corrected as inertia's.
            self._frequency("frequency, loaded", pair, "loaded"),
            self._frequency("frequency, no load", pair, "no_load"),
            *between,
            self._place(pair),
            bounded_effect("finite band", abs(unresolved)),
        )
        return model_of(
            evaluation.torque_nm - support_nm,
            effects,
            scales=(gain(self.instrument), load(self.described)),
            correlations={LEARNED: np.asarray(self.rig.covariance / np.outer(u, u))},
            lines={BETWEEN: Line(0.0)},
        )

    def _sensor(self, evaluation: Evaluation) -> tuple[Effect, ...]:
        """Return the effects of the transducer's errors, except the gain.

        Both runs are of one transducer: an offset, and drift between the runs, fall out of the mean
        of both strokes; what drifts within half a swing does not. Of a smooth error curve only the
        slope between the torques of the two runs is left.
        """
        runs = (evaluation.pair.loaded, evaluation.pair.no_load)
        readings = [float(np.abs(run.torque_nm).max()) for run in runs]
        # Of a drift over the whole recording, the part that falls into half a swing.
        slow = 1 / (2 * min(len(run.changes_nm) for run in runs))
        return (
            curve_slope(self.instrument, evaluation.torque_nm),
            Effect(stated(self.instrument, "drift", "sensor drift"), slow),
            Effect(stated(self.instrument, "offset", "sensor offset"), 0.0),
            *one_figure(self.instrument),
            *transducer_effects(self.instrument, evaluation.torque_nm, readings, slow=slow),
        )

    def _drive_line(self, pair: Pair) -> tuple[Effect, ...]:
        """Return fn, z, J, share and delay, with their covariance from the no-load sweep."""
        line, u = self.rig.line, np.sqrt(np.diag(self.rig.covariance))
        above, below = (
            np.array(
                [self._torque(with_vector(line, vector(line) + s), pair) for s in np.diag(step)]
            )
            for step in (u, -u)
        )
        slopes = (above - below) / (2 * u)
        return tuple(
            Effect(
                Input(
                    name,
                    float(value),
                    float(u_value),
                    self.rig.dof,
                    Distribution.NORMAL,
                    unit,
                    common=True,
                    line=LEARNED,
                    ensemble=LEARNED,
                ),
                float(slope),
            )
            for (name, unit), value, u_value, slope in zip(
                LEARNED_UNITS.items(), vector(line), u, slopes, strict=True
            )
        )

    def _slope(self, rig: Identified, limit: float, evaluation: Evaluation) -> float:
        """Return how the torque goes with a quantity, by the rig as learned at that limit of it."""
        torque = starting_torque(rig.line, rig.friction, evaluation.pair, self.settings.window)
        return (torque - evaluation.maximum_nm) / limit if limit > 0 else 0.0

    def _frequency(self, name: str, pair: Pair, run: str) -> Effect:
        mean: MeanSwing = getattr(pair, run)
        u, cycles = mean.frequency_u_hz, len(mean.changes_nm)
        frequency = Input(name, mean.frequency_hz, u, cycles - 1.0, Distribution.T, "Hz")
        if u == 0:
            return Effect(frequency, 0.0)
        above, below = (
            self._torque(self.rig.line, replace(pair, **{run: replace(mean, frequency_hz=hz)}))
            for hz in (mean.frequency_hz + u, mean.frequency_hz - u)
        )
        return Effect(frequency, (above - below) / (2 * u))

    def _place(self, pair: Pair) -> Effect:
        """Return what it may matter that friction follows the load or the drive.

        `share` is learned from the support's friction alone, as one number: a part of the whole
        difference stays open. Its sign is not known; it is taken to be the same at all points.
        """
        load, drive = (
            self._torque(replace(self.rig.line, share=share), pair) for share in (1.0, 0.0)
        )
        return Effect(limited("place of the friction", PLACE, "1"), abs(load - drive))

    def _torque(self, line: DriveLine, pair: Pair) -> float:
        return starting_torque(line, self.rig.friction, pair, self.settings.window)


def _repeatability(name: str, evaluation: Evaluation, run: int) -> Effect:
    """Return the jackknife over one run: what the torque is without each of its cycles."""
    torques = evaluation.reversals.torque(evaluation.without_each_nm[run])
    mean = (evaluation.pair.loaded, evaluation.pair.no_load)[run]
    return scattered(name, *jackknife_error(torques, in_a_row=mean.of_cycles))
