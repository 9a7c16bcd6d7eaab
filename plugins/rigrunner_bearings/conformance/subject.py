"""A compensation under check: its results for recordings, from the one analysis."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.analysis.analyse import analyse
from rigrunner.api import DataError
from rigrunner.procedure import AnalysisRef
from rigrunner.registry import Registry, load_registry
from rigrunner.signal.coverage import expanded
from rigrunner_bearings.api import CompensationRecord
from rigrunner_bearings.api.measurand import Condition
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.conformance.recordings import CLOSED_FORM, Runs, starts, swings
from rigrunner_bearings.study.tools import tools
from rigrunner_bearings.torque.settings import NO_LOAD
from rigrunner_testing.check import Nonconformity, demand
from rigrunner_testing.subjects import Subject

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_bearings.api.compensations import Compensation


@dataclass(frozen=True)
class CompensationSubject(Subject):
    """A compensation plugin, with recordings of the motion that it is for."""

    @property
    def record(self) -> CompensationRecord:
        """What the plugin declares."""
        return self.record_as(CompensationRecord)

    @property
    def of_starts(self) -> bool:
        """Whether it takes starts from rest; all others take swings."""
        yields = self.record.yields
        return yields is not None and yields.condition is Condition.FROM_REST

    @cached_property
    def runs(self) -> Runs:
        """The recordings that most checks take."""
        return self.recorded(0)

    @cached_property
    def plain(self) -> Compensation:
        """Its result for them."""
        return self.number(self.runs)

    def recorded(self, number: int, rate_hz: float | None = None) -> Runs:
        """Return recordings of one rig, sampled at another rate where one is given."""
        if self.of_starts:
            return starts(number, rate_hz)
        return swings(CLOSED_FORM, number, rate_hz)

    def number(self, runs: Runs) -> Compensation:
        """Return its result for the recordings; raise Nonconformity if it gives no number."""
        compensation = self.answer(runs)
        reason = compensation.not_applicable or "and no reason"
        demand(compensation.points, f"it gives no number: {reason}")
        return compensation

    def answer(self, runs: Runs) -> Compensation:
        """Return its result for the recordings, also if that is that it does not apply."""
        return self._compensation(runs, of_starts=self.of_starts)

    def answer_to_other_motion(self) -> Compensation:
        """Return its result for starts if it is for swings, and the reverse."""
        runs = swings(CLOSED_FORM, 0) if self.of_starts else starts(0)
        return self._compensation(runs, of_starts=not self.of_starts)

    def _compensation(self, runs: Runs, *, of_starts: bool) -> Compensation:
        settings: dict[str, Any] = {
            "outliers": {"grubbs": {"alpha": 0.05}},
            "compensations": [{self.name: dict(self.settings)}],
        }
        if not of_starts:
            settings |= {
                "despike": {"hampel": {"window": 11}},
                "fits": [{"polynomial": {"degree": 2}}],
                "no_load": {"from": "latest", "procedure": "SSPB-NLI"},
            }
        partners = {} if runs.no_load is None else {NO_LOAD: runs.no_load}
        result = analyse(
            replace(runs.loaded, partners=partners),
            (AnalysisRef.model_validate({"breakaway" if of_starts else "swing_torque": settings}),),
            acceptance=None,
            measurand=tools().measurand,
            lookup=self._lookup,
        )
        return TorqueDetails.of(result).compensations[self.name]

    @cached_property
    def _lookup(self) -> Registry:
        """The plugin and what is shipped: an analysis needs an outlier rule and a fit too."""
        if "grubbs" in self.registry.names("outlier_rule"):
            return self.registry
        return Registry((*load_registry().plugins, self.plugin))


def torques_nm(compensation: Compensation) -> Array:
    """Return the torque at each set-point."""
    return np.array([point.torque.value for point in compensation.points])


def expanded_nm(compensation: Compensation) -> Array:
    """Return the expanded uncertainty (95 %) at each set-point."""
    return np.array([expanded(point.torque) for point in compensation.points])


def refusal_reason(subject: CompensationSubject, runs: Runs) -> str:
    """Return its reason for refusing the recordings; '' if it gives a number."""
    try:
        compensation = subject.answer(runs)
    except DataError as error:
        return str(error)
    if compensation.points:
        return ""
    if not compensation.not_applicable.strip():
        raise Nonconformity("it gives neither a number nor a reason")
    return compensation.not_applicable
