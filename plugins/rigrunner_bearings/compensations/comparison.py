"""Makes the two runs comparable before they are compared: what they differ by, beside the bearing.

Hum of the mains, friction of the support that grows under load, gains of the recordings,
and the inertia. Each is taken out of the recordings, and what stays open of it is an effect.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Distribution, Effect, Input
from rigrunner.signal.inputs import bounded_effect, limited
from rigrunner_bearings.compensations import response
from rigrunner_bearings.compensations.bearing import Pair, mean_swing
from rigrunner_bearings.compensations.hum import without_hum
from rigrunner_bearings.compensations.limits import support_drift, support_under_load
from rigrunner_bearings.compensations.recording_gains import recording_gains

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import Array
    from rigrunner_bearings.api.compensations import SwingSweep
    from rigrunner_bearings.compensations.bearing import MeanSwing
    from rigrunner_bearings.compensations.evaluation import Evaluation
    from rigrunner_bearings.compensations.identification import Identified
    from rigrunner_bearings.compensations.limits import SupportGrowth
    from rigrunner_bearings.compensations.recording_gains import RecordingGains
    from rigrunner_bearings.compensations.settings import InverseSettings

LINE = "gain and inertia between the runs"
SLIP = "slip of the support under load"

TRIAL = 1e-3
"""Of a torque that is added, to see what the result changes by."""

EITHER = 1.1
"""Times what a gain would make in place of an inertia: it is one or the other, and both lie at the
ends of a rectangle, which 95 % of it leaves out."""

BUILT_UP = 80
"""Percentile over the swing of the friction that counts as all of it: reversals are below."""
NEGLIGIBLE = 1e-9
"""Of the variance of all points."""


@dataclass(frozen=True, eq=False)
class ComparableRuns:
    """Both runs of a sweep, made comparable; one pair for each loaded point."""

    rig: Identified
    pairs: tuple[Pair, ...]
    gains: RecordingGains
    hum_nm: tuple[float, ...]
    """Standard uncertainty of what is left of it, at each point."""
    support: SupportGrowth
    """Of the friction under load: the growth is taken out."""
    drift: Input | None
    """Of the support's dry friction from one run to the other, a part of it."""

    def effects(self, evaluations: Sequence[Evaluation]) -> list[tuple[Effect, ...]]:
        """Return for each point what is still open of what was taken out."""
        gains = self._gains(evaluations)
        hums = (
            (Effect(Input("hum of the mains", 0.0, u_nm, inf, Distribution.NORMAL), 1.0),)
            if u_nm
            else ()
            for u_nm in self.hum_nm
        )
        return [
            (*open_gains, *hum, *self._support(evaluation, share))
            for open_gains, evaluation, hum, share in zip(
                gains, evaluations, hums, self.support.at_points, strict=True
            )
        ]

    def _gains(self, evaluations: Sequence[Evaluation]) -> list[tuple[Effect, ...]]:
        """Return the effects of the gains and of the inertia, which the points have in common.

        The inputs are the principal components of the points' joint covariance, each of variance 1.
        What changed between the runs may be the gain in place of the inertia; then friction was
        measured wrong by as much.
        """
        count = len(evaluations)
        slopes = np.zeros((count, 2 * count + 1))
        cause_slopes = []
        for i, evaluation in enumerate(evaluations):
            run = evaluation.pair.no_load
            inertial = _trial(evaluation, inertia_torque(self.rig, run))
            no_load = _trial(evaluation, self.rig.line.at_load(run.waveform, run.frequency_hz))
            loaded = no_load + evaluation.maximum_nm
            slopes[i, [i, count + i, 2 * count]] = -no_load, loaded, inertial
            cause_slopes.append(loaded - inertial)
        variances, directions = np.linalg.eigh(slopes @ self.gains.covariance @ slopes.T)
        kept = variances > NEGLIGIBLE * variances.sum()
        parts = directions[:, kept] * np.sqrt(variances[kept])
        components = [
            Input(
                f"{LINE}, component {number}",
                0.0,
                1.0,
                inf,
                Distribution.NORMAL,
                "1",
                common=True,
                line=LINE,
            )
            for number in range(1, parts.shape[1] + 1)
        ]
        cause = replace(limited(f"{LINE}, cause", EITHER * self.gains.inertia, "1"), line=LINE)
        return [
            (*map(Effect, components, map(float, row)), Effect(cause, slope))
            for row, slope in zip(parts, cause_slopes, strict=True)
        ]

    def _support(self, evaluation: Evaluation, share: float) -> Iterator[Effect]:
        """Yield what dry friction that grew with the load adds: it builds up at the maximum.

        The way over which it does may have grown as well; what is taken out lies between the two.
        """
        longer, same = (_trial(evaluation, torque_nm) for torque_nm in self.rig.friction.grown)
        yield self.support.effect(same, share)
        if growth := self.support.growth * share:
            yield bounded_effect(SLIP, abs(growth * (longer - same) / 2))
        if self.drift is not None:
            yield Effect(self.drift, -same)


def comparable_runs(
    rig: Identified, sweep: SwingSweep, templates: Sequence[MeanSwing], settings: InverseSettings
) -> ComparableRuns:
    """Return both runs made comparable; the settings are those of this very rig."""
    size = rig.friction.swing.size
    pairs = [
        Pair(mean_swing(loaded, size), template)
        for loaded, template in zip(sweep.loaded, templates, strict=True)
    ]
    points = (*sweep.loaded, *sweep.no_load)
    pairs, hum_nm = without_hum(rig, pairs, points, settings.mains_frequency)
    support, (longer, same) = support_under_load(settings, sweep), rig.friction.grown
    grown = support.growth * (longer + same) / 2
    pairs = [
        replace(pair, loaded=_minus(rig, pair.loaded, share * grown))
        for pair, share in zip(pairs, support.at_points, strict=True)
    ]
    gains = recording_gains(rig, pairs, settings.inertia_mismatch)
    comparable = tuple(
        Pair(
            _rescaled(
                _minus(rig, pair.loaded, gains.inertia * inertia_torque(rig, pair.loaded)), loaded
            ),
            _rescaled(pair.no_load, no_load),
        )
        for pair, loaded, no_load in zip(pairs, gains.loaded, gains.no_load, strict=True)
    )
    return ComparableRuns(
        rig, comparable, gains, tuple(hum_nm), support, support_drift(settings, sweep)
    )


def inertia_torque(rig: Identified, run: MeanSwing) -> Array:
    """Return the torque of the inertia in one run, shape (n,)."""
    acceleration = rig.friction.swing.acceleration_per_hz2
    return np.asarray(rig.line.inertia_kgm2 * acceleration * run.frequency_hz**2)


def _minus(rig: Identified, run: MeanSwing, torque_nm: Array) -> MeanSwing:
    """Return a run without what the sensor shows of a torque at the load, shape (n,)."""
    harmonic_hz = run.frequency_hz * np.arange(len(torque_nm) // 2 + 1, dtype=float)
    at_sensor = response.apply(rig.line.sensor(harmonic_hz), torque_nm)
    return replace(run, torque_nm=run.torque_nm - at_sensor)


def _rescaled(run: MeanSwing, gain: float) -> MeanSwing:
    factor = 1 + gain
    return replace(run, torque_nm=run.torque_nm / factor, changes_nm=run.changes_nm / factor)


def built_up(evaluation: Evaluation, rig: Identified) -> tuple[float, float]:
    """Return what of the support's dry friction is built up at the maximum, N·m, and all of it."""
    dry_nm = rig.friction.dry_nm
    return _trial(evaluation, dry_nm), float(np.percentile(np.abs(dry_nm), BUILT_UP))


def _trial(evaluation: Evaluation, torque_nm: Array) -> float:
    """Return what the result changes by with that torque at the load, over the torque's size."""
    more = evaluation.reversals.torque(evaluation.bearing_nm + TRIAL * torque_nm)
    return (float(more) - evaluation.maximum_nm) / TRIAL
