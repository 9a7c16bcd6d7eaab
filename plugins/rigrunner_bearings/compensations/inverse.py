"""Starting torque from whole swings: loaded minus no-load, with the drive line undone.

A template of all that the rig itself puts on the sensor is taken from the loaded run. The
difference still went through the drive line's resonance and the low-pass filter; both are inverted
(the filter from the register, the resonance learned from the no-load sweep). The starting torque is
the greatest torque shortly after a reversal, mean of both strokes. Where the template comes from is
what the two methods at the end differ in.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError, Estimate
from rigrunner.api.checks import skipped
from rigrunner.signal.repeatability import influences
from rigrunner_bearings.api.compensations import Compensation, Trace
from rigrunner_bearings.compensations import checks
from rigrunner_bearings.compensations.bearing import mean_swing
from rigrunner_bearings.compensations.budget import LEARNED_UNITS, Budget
from rigrunner_bearings.compensations.comparison import built_up, comparable_runs
from rigrunner_bearings.compensations.effects import by_halves, by_speed, mismatch
from rigrunner_bearings.compensations.evaluation import evaluate
from rigrunner_bearings.compensations.harmonics import mean_torque
from rigrunner_bearings.compensations.identification import identify, identify_again, vector
from rigrunner_bearings.compensations.limits import (
    settings_of_rig,
    states_support,
    support_drift,
    support_under_load,
)
from rigrunner_bearings.compensations.matching import pairs
from rigrunner_bearings.compensations.model_template import no_load_model
from rigrunner_bearings.compensations.rig_errors import RigErrors
from rigrunner_bearings.compensations.swing import (
    interpolated,
    make_swing,
    measured_ratio,
    spring_torque,
)
from rigrunner_bearings.compensations.under_load import effect, line_under_load
from rigrunner_bearings.signal.compensated import compensated_point
from rigrunner_bearings.signal.swings import kept_cycles, with_swings

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api import Array, Check, Effect, Instrument
    from rigrunner_bearings.api.compensations import CompensatedPoint, Sweep, SwingSweep
    from rigrunner_bearings.api.points import SwingPoint
    from rigrunner_bearings.compensations.bearing import MeanSwing
    from rigrunner_bearings.compensations.effects import BySpeed, Mismatch
    from rigrunner_bearings.compensations.evaluation import Evaluation
    from rigrunner_bearings.compensations.filters import Filter
    from rigrunner_bearings.compensations.identification import Identified
    from rigrunner_bearings.compensations.recording_gains import RecordingGains
    from rigrunner_bearings.compensations.settings import InverseSettings, TemplateInverseSettings
    from rigrunner_bearings.compensations.under_load import LineUnderLoad


MEASURAND = "load-induced starting torque at the reversals of the swing"
NOTES = (
    "The torque that the load adds: friction that the bearing has without load is not in it.",
    "At the reversals of a swing: not a breakaway after a rest.",
    "Holds if the support's friction does not grow under load by more than its component states.",
)


@dataclass(frozen=True)
class _Diagnosis:
    asymmetry: float
    """Half of what the strokes differ by, over their mean."""
    evaluation: Evaluation
    speed: BySpeed
    mismatch: Mismatch
    scattered_nm: tuple[Array, ...]
    """What each cycle of a run moves the torque by, shapes (cycles,); of runs, not of models."""
    spring_nm: float
    """What of it follows the angle, at the swing's end."""
    under_load_nm: tuple[float, float] | None
    """The change of the torque by the drive line of the loaded sweep, and its uncertainty."""


@dataclass(frozen=True)
class Inverse(ABC):
    """A compensation by a template of whole swings and the inverse of the drive line."""

    settings: InverseSettings

    @abstractmethod
    def templates(self, sweep: SwingSweep, rig: Identified) -> Sequence[MeanSwing]:
        """Return for each loaded point what the sensor would show without load; DataError."""

    def __call__(self, sweep: Sweep) -> Compensation:
        """Return the starting torque per frequency.

        Raises DataError for a point without whole swings, a frequency without no-load partner, a
        register without low-pass filter, and too few no-load frequencies to learn the resonance
        from.
        """
        sweep = with_swings(sweep)
        low_pass = _low_pass(sweep.instrument)
        ratio = measured_ratio(sweep.no_load)
        swing = make_swing(ratio)
        rig = identify(sweep.no_load, swing, low_pass)
        larger = make_swing(ratio * (1 + sweep.rig.angle_tolerance))
        rescaled = identify_again(sweep.no_load, larger, low_pass, rig)
        wider = low_pass.scaled(1 + self.settings.low_pass_tolerance)
        refiltered = identify_again(sweep.no_load, swing, wider, rig)
        settings = settings_of_rig(self.settings, sweep.rig)
        budget = Budget(settings, sweep.instrument, sweep.rig, rig, refiltered, rescaled)
        runs = comparable_runs(rig, sweep, self.templates(sweep, rig), settings)
        evaluations = [evaluate(rig, pair, settings.window) for pair in runs.pairs]
        loaded_line = line_under_load(sweep.loaded, rig)
        if loaded_line is not None:
            # The pairs were made comparable: the change of the inertia is out of them.
            line = loaded_line.line
            line = replace(line, inertia_kgm2=line.inertia_kgm2 / (1 + runs.gains.inertia))
            loaded_line = replace(loaded_line, line=line)
        effects = runs.effects(evaluations)
        diagnosed_points = [
            self._point(
                budget,
                loaded,
                evaluation,
                between,
                support_nm=support_nm,
                loaded_line=loaded_line,
            )
            for loaded, evaluation, between, support_nm in zip(
                sweep.loaded, evaluations, effects, runs.support.torques_nm, strict=True
            )
        ]
        points = tuple(point for point, _ in diagnosed_points)
        diagnoses = [diagnosis for _, diagnosis in diagnosed_points]
        return Compensation(
            measurand=MEASURAND,
            points=points,
            parameters=_parameters(rig, runs.gains),
            checks=_checks(sweep, rig, points, diagnoses, settings),
            notes=NOTES,
        )

    def torques(self, sweep: Sweep) -> Array:
        """Return the torque per point in N·m, shape (points,), without its uncertainty."""
        sweep = with_swings(sweep)
        rig = self._identified_rig(sweep)
        settings = settings_of_rig(self.settings, sweep.rig)
        runs = comparable_runs(rig, sweep, self.templates(sweep, rig), settings)
        torques_nm = [evaluate(rig, pair, settings.window).torque_nm for pair in runs.pairs]
        return np.array(torques_nm) - runs.support.torques_nm

    def perturbation(self, sweep: Sweep) -> RigErrors:
        """Return what puts the errors that the settings state into the sweep."""
        settings = settings_of_rig(self.settings, sweep.rig)
        support, drift = support_under_load(settings, sweep), support_drift(settings, sweep)
        return RigErrors(settings, support, self._identified_rig(with_swings(sweep)), drift)

    def _identified_rig(self, sweep: SwingSweep) -> Identified:
        swing = make_swing(measured_ratio(sweep.no_load))
        return identify(sweep.no_load, swing, _low_pass(sweep.instrument))

    def _point(
        self,
        budget: Budget,
        loaded: SwingPoint,
        evaluation: Evaluation,
        between: Sequence[Effect],
        *,
        support_nm: float,
        loaded_line: LineUnderLoad | None,
    ) -> tuple[CompensatedPoint, _Diagnosis]:
        swing = budget.rig.friction.swing
        raw_nm = interpolated(mean_torque(loaded), swing.size)
        forward, backward = evaluation.reversals.of_strokes(evaluation.bearing_nm)
        step = len(evaluation.bearing_nm) // len(loaded.angle_rad)
        point = compensated_point(
            budget.model(evaluation, between, support_nm),
            set_frequency_hz=loaded.set_frequency_hz,
            frequency_hz=evaluation.pair.loaded.frequency_hz,
            raw_nm=float(np.ptp(raw_nm) / 2),
            trace=Trace(
                angle_rad=loaded.angle_rad,
                raw_nm=raw_nm[::step],
                no_load_nm=evaluation.pair.no_load.torque_nm[::step],
                compensated_nm=evaluation.bearing_nm[::step],
            ),
            cycles_used=int(kept_cycles(loaded).sum()),
        )
        asymmetry = float((forward - backward) / (forward + backward))
        under_load_nm = None if loaded_line is None else effect(evaluation, budget.rig, loaded_line)
        spring = spring_torque(swing, evaluation.bearing_nm)
        runs = (evaluation.pair.loaded, evaluation.pair.no_load)
        scattered_nm = tuple(
            influences(evaluation.reversals.torque(without_nm))
            for run, without_nm in zip(runs, evaluation.without_each_nm, strict=True)
            if run.of_cycles
        )
        return point, _Diagnosis(
            asymmetry,
            evaluation,
            by_speed(evaluation, swing),
            mismatch(evaluation, budget.rig),
            scattered_nm,
            spring,
            under_load_nm,
        )


def _low_pass(instrument: Instrument) -> Filter:
    if instrument.low_pass is None:
        raise DataError(
            f"the register has no low_pass for {instrument.channel} (serial {instrument.serial}), "
            "and an unknown filter cannot be undone",
            hint="add it to the station, such as "
            "low_pass: {type: butterworth, order: 2, corner: 1 kHz}",
        )
    return instrument.low_pass


def _parameters(rig: Identified, gains: RecordingGains) -> Mapping[str, Estimate]:
    u = np.sqrt(np.diag(rig.covariance))
    parameters = {
        name: Estimate(float(value), float(u_value), rig.dof, unit)
        for (name, unit), value, u_value in zip(
            LEARNED_UNITS.items(), vector(rig.line), u, strict=True
        )
    }
    inertia_change = Estimate(gains.inertia, sqrt(gains.covariance[-1, -1]), inf, "1")
    return parameters | {"change of the inertia": inertia_change}


def _checks(
    sweep: SwingSweep,
    rig: Identified,
    points: Sequence[CompensatedPoint],
    diagnoses: Sequence[_Diagnosis],
    settings: InverseSettings,
) -> tuple[Check, ...]:
    evaluations = [diagnosis.evaluation for diagnosis in diagnoses]
    running_nm = [diagnosis.speed.running_nm for diagnosis in diagnoses]
    build_up = (
        skipped(checks.BUILD_UP.name, "the station states what the support does under load")
        if states_support(settings, sweep.rig)
        else checks.support_has_built_up(
            points, [built_up(evaluation, rig) for evaluation in evaluations], running_nm
        )
    )
    return (
        checks.independent_cycles(points, [diagnosis.scattered_nm for diagnosis in diagnoses]),
        checks.positive(points, running_nm),
        checks.drive_line(rig.misfit, by_halves(sweep.no_load, rig, evaluations, settings.window)),
        checks.symmetry(points, [diagnosis.asymmetry for diagnosis in diagnoses]),
        checks.same_inertia(points, [diagnosis.mismatch for diagnosis in diagnoses]),
        checks.no_growth(points, [diagnosis.speed for diagnosis in diagnoses]),
        checks.same_drive_line(
            points, [diagnosis.under_load_nm for diagnosis in diagnoses if diagnosis.under_load_nm]
        ),
        checks.no_spring(points, [diagnosis.spring_nm for diagnosis in diagnoses]),
        checks.delay(rig.line.delay_s),
        checks.coupling(rig.line.natural_hz, sweep.rig.natural_frequency),
        checks.sampling((*sweep.loaded, *sweep.no_load), rig.line.natural_hz),
        build_up,
    )


@dataclass(frozen=True)
class TemplateInverse(Inverse):
    """The compensation `template_inverse`: the recorded no-load run of the same frequency.

    Raises DataError for a frequency without no-load run.
    """

    settings: TemplateInverseSettings

    def templates(self, sweep: SwingSweep, rig: Identified) -> Sequence[MeanSwing]:
        """Return the mean swing of each loaded point's partner."""
        matched = pairs(sweep.loaded, sweep.no_load, self.settings.frequency_match)
        return [mean_swing(no_load, rig.friction.swing.size) for _, no_load in matched]


class ModelInverse(Inverse):
    """The compensation `model_inverse`: raises DataError for a frequency outside of the sweep.

    For frequencies that the sweep does not have; it also averages the noise of the template over
    all of them. A rig that does not follow the model (see the check 'drive line') is served better
    by `template_inverse`.
    """

    def templates(self, sweep: SwingSweep, rig: Identified) -> Sequence[MeanSwing]:
        """Return the model's torque at each loaded point's measured frequency."""
        model = no_load_model(sweep.no_load, rig)
        return [model.template(point.frequency_hz.value) for point in sweep.loaded]
