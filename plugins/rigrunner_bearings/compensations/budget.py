"""The measurement model of a starting torque from whole swings, and what its inputs are worth.

    T = (T_d + sum c_i (x_i - estimate_i)) / ((1 + gain) (1 + load))

T_d is what the algorithm makes of the two runs at the best estimates. Each c_i says what it makes
of another x_i: found by trial through the algorithm itself (GUM 5.1.3, note 2), or by its equation.
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

    from rigrunner.api import Array, Instrument, MeasurementModel
    from rigrunner_bearings.api.rig import RigDescription
    from rigrunner_bearings.compensations.bearing import MeanSwing, Pair
    from rigrunner_bearings.compensations.drive_line import DriveLine
    from rigrunner_bearings.compensations.evaluation import Evaluated
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
    support_nm: float
    """That the load is known to add to the support's friction."""

    def model(self, found: Evaluated, between: Sequence[Effect]) -> MeasurementModel:
        """Return the model of one point; `between` is what the two runs may still differ by."""
        pair = found.pair
        effects = (
            _repeatability("repeatability, loaded", found, 0),
            _repeatability("repeatability, no load", found, 1),
            bounded_effect("noise in the maximum", found.bias_nm),
            *self._sensor(found),
            *self._learned(pair),
            self._low_pass(found),
            self._angle_scale(found),
            *self._frequencies(pair),
            *between,
            self._place(pair),
            self._band(found),
        )
        return model_of(
            found.torque_nm - self.support_nm,
            effects,
            scales=(gain(self.instrument), load(self.described)),
            correlations={LEARNED: _correlation(self.rig.covariance)},
            lines={BETWEEN: Line(0.0)},
        )

    def _sensor(self, found: Evaluated) -> tuple[Effect, ...]:
        """Return what the transducer's errors come to, besides the gain.

        Both runs are of one transducer: an offset, and drift between the runs, fall out of the mean
        of both strokes; what drifts within half a swing does not. Of a smooth error curve only the
        slope between the torques of the two runs is left.
        """
        cycles = min(len(run.replicates_nm) for run in (found.pair.loaded, found.pair.no_load))
        return (
            curve_slope(self.instrument, found.torque_nm),
            # Of a drift over the whole recording, the part that falls into half a swing.
            Effect(stated(self.instrument, "drift", "sensor drift"), 1 / (2 * cycles)),
            Effect(stated(self.instrument, "offset", "sensor offset"), 0.0),
            *one_figure(self.instrument),
            *self._stated(found, slow=1 / (2 * cycles)),
        )

    def _stated(self, found: Evaluated, *, slow: float) -> tuple[Effect, ...]:
        """Return what the register states of the transducer besides its accuracy."""
        runs = (found.pair.loaded, found.pair.no_load)
        readings = [float(np.abs(run.torque_nm).max()) for run in runs]
        return transducer_effects(self.instrument, found.torque_nm, readings, slow=slow)

    def _learned(self, pair: Pair) -> tuple[Effect, ...]:
        """Return fn, z, J, share and delay, with their covariance from the no-load sweep."""
        line, u = self.rig.line, np.sqrt(np.diag(self.rig.covariance))
        above, below = (
            np.array([self._of(with_vector(line, vector(line) + s), pair) for s in np.diag(step)])
            for step in (u, -u)
        )
        return tuple(
            Effect(self._learned_input(*known), float(change))
            for *known, change in zip(
                LEARNED_UNITS.items(), vector(line), u, (above - below) / (2 * u), strict=True
            )
        )

    def _learned_input(self, named: tuple[str, str], value: float, u: float) -> Input:
        name, unit = named
        return Input(
            name,
            float(value),
            float(u),
            self.rig.dof,
            Distribution.NORMAL,
            unit,
            common=True,
            line=LEARNED,
            ensemble=LEARNED,
        )

    def _low_pass(self, found: Evaluated) -> Effect:
        rig, corner = self.refiltered, corner_hz(self.rig.line.low_pass)
        limit_hz = corner_hz(rig.line.low_pass) - corner
        torque = starting_torque(rig.line, rig.friction, found.pair, self.settings.window)
        slope = (torque - found.maximum_nm) / limit_hz if limit_hz > 0 else 0.0
        return Effect(limited("low-pass filter", limit_hz, "Hz", corner), slope)

    def _angle_scale(self, found: Evaluated) -> Effect:
        """Return what a swing larger than the angle channel shows does: J is learned again."""
        rig, limit = self.rescaled, self.described.angle_tolerance
        torque = starting_torque(rig.line, rig.friction, found.pair, self.settings.window)
        slope = (torque - found.maximum_nm) / limit if limit > 0 else 0.0
        return Effect(limited("angle scale", limit, "1"), slope)

    def _frequencies(self, pair: Pair) -> tuple[Effect, ...]:
        """Return the two runs' frequencies: their difference is corrected as inertia's."""
        return (
            self._frequency("frequency, loaded", pair, "loaded"),
            self._frequency("frequency, no load", pair, "no_load"),
        )

    def _frequency(self, name: str, pair: Pair, run: str) -> Effect:
        mean: MeanSwing = getattr(pair, run)
        u, cycles = mean.frequency_u_hz, len(mean.replicates_nm)
        at = Input(name, mean.frequency_hz, u, cycles - 1.0, Distribution.T, "Hz")
        if u == 0:
            return Effect(at, 0.0)
        above, below = (
            self._of(self.rig.line, replace(pair, **{run: replace(mean, frequency_hz=hz)}))
            for hz in (mean.frequency_hz + u, mean.frequency_hz - u)
        )
        return Effect(at, (above - below) / (2 * u))

    def _place(self, pair: Pair) -> Effect:
        """Return what it may matter that friction follows the load or the drive.

        `share` is learned from the support's friction alone, as one number: a part of the whole
        difference stays open. Of which sign is not known; it is taken to be alike at all points.
        """
        load, drive = (self._of(replace(self.rig.line, share=share), pair) for share in (1.0, 0.0))
        return Effect(limited("place of the friction", PLACE, "1"), abs(load - drive))

    def _band(self, found: Evaluated) -> Effect:
        line = self.rig.line
        coarser = replace(line, harmonics=round(COARSER * line.harmonics))
        change = self._of(coarser, found.pair) - found.maximum_nm
        return bounded_effect("finite band", abs(change))

    def _of(self, line: DriveLine, pair: Pair) -> float:
        return starting_torque(line, self.rig.friction, pair, self.settings.window)


def _repeatability(name: str, found: Evaluated, run: int) -> Effect:
    """Return the jackknife over one run: what the torque is without each of its cycles."""
    torques = found.where.torque(found.without_each_nm[run])
    mean = (found.pair.loaded, found.pair.no_load)[run]
    return scattered(name, *jackknife_error(torques, in_a_row=mean.of_cycles))


def _correlation(covariance: Array) -> Array:
    u = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(u, u))
