"""What the analyses of torque are called, need and yield. Nothing here loads numpy."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.api import AnalysisRecord, PluginError, hookimpl

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rigrunner.api import AnalysisContext, Requirements, ResultDefinition, RunData
    from rigrunner.api.planned import ExpectedReading, PlannedRun, PlanProblem
    from rigrunner_bearings.torque.analysis import TorqueAnalysis
    from rigrunner_bearings.torque.live import LiveTorque
    from rigrunner_bearings.torque.settings import TorqueSettings

_LIMIT = "rigrunner_bearings.api.measurand:LimitMeasurand"
_SETTINGS = "rigrunner_bearings.torque.settings"
_RECORDINGS = "rigrunner_bearings.conformance.recordings"


@hookimpl
def rigrunner_analyses() -> list[AnalysisRecord]:
    """Return the analyses of torque."""
    return [
        AnalysisRecord(
            name="swing_torque",
            help="Torque at the reversals of swings, from recordings or from measured values",
            settings=f"{_SETTINGS}:SwingTorque",
            measurand="torque",
            limit_measurand=_LIMIT,
            factory=_analysis,
            yields=_definitions,
            requires=_requirements,
            partner_problems=_partner_problems,
            plan_problems=_plan_problems,
            entering=_entering,
            expects=_expects,
            live=_live,
            changed=_changed,
            in_context=True,
            trial={
                "despike": {"hampel": {"window": 11}},
                "outliers": {"grubbs": {"alpha": 0.05}},
                "fits": [{"polynomial": {"degree": 2}}],
                "no_load": {"from": "latest", "procedure": "SSPB-NLI"},
                "compensations": ["peak_same_frequency"],
            },
            trial_run=f"{_RECORDINGS}:run_of_swings",
        ),
        AnalysisRecord(
            name="breakaway",
            help="Torque at the first movement: every recording is a start from rest",
            settings=f"{_SETTINGS}:Breakaway",
            measurand="torque",
            limit_measurand=_LIMIT,
            factory=_analysis,
            yields=_definitions,
            requires=_requirements,
            partner_problems=_partner_problems,
            plan_problems=_plan_problems,
            entering=_entering,
            expects=_expects,
            changed=_changed,
            in_context=True,
            trial={
                "outliers": {"grubbs": {"alpha": 0.05}},
                "compensations": ["breakaway_peak"],
            },
            trial_run=f"{_RECORDINGS}:run_of_starts",
        ),
    ]


def _analysis(settings: TorqueSettings, context: AnalysisContext) -> TorqueAnalysis:
    from rigrunner_bearings.torque.analysis import TorqueAnalysis  # noqa: PLC0415  (numpy)

    return TorqueAnalysis(settings, context)


def _live(settings: TorqueSettings, context: AnalysisContext) -> LiveTorque:
    from rigrunner_bearings.torque.analysis import TorqueAnalysis  # noqa: PLC0415  (numpy)
    from rigrunner_bearings.torque.live import LiveTorque  # noqa: PLC0415  (likewise)

    return LiveTorque(TorqueAnalysis(settings, replace(context, interim=True)))


def _definitions(
    settings: TorqueSettings, context: AnalysisContext
) -> tuple[ResultDefinition, ...]:
    from rigrunner_bearings.torque.definition import definitions  # noqa: PLC0415  (likewise)

    if settings.compensations and settings.primary_plugin is None:
        raise PluginError("none of the compensations is the primary one")
    return definitions(settings, context)


def _requirements(settings: TorqueSettings, context: AnalysisContext) -> Requirements:
    from rigrunner_bearings.torque.definition import requirements  # noqa: PLC0415  (likewise)

    return requirements(settings, context)


def _partner_problems(
    settings: TorqueSettings, planned: PlannedRun, partner: RunData, context: AnalysisContext
) -> Iterator[str]:
    from rigrunner_bearings.torque.planning import partner_problems  # noqa: PLC0415  (numpy)

    return partner_problems(settings, planned, partner, context)


def _plan_problems(
    settings: TorqueSettings, planned: PlannedRun, context: AnalysisContext
) -> Iterable[PlanProblem]:
    from rigrunner_bearings.torque.planning import plan_problems  # noqa: PLC0415  (likewise)

    return plan_problems(settings, planned, context)


def _entering(
    settings: TorqueSettings, planned: PlannedRun, context: AnalysisContext
) -> Iterable[str]:
    from rigrunner_bearings.torque.planning import entering  # noqa: PLC0415  (likewise)

    return entering(settings, planned, context)


def _expects(
    settings: TorqueSettings, planned: PlannedRun, context: AnalysisContext
) -> Iterable[ExpectedReading]:
    from rigrunner_bearings.torque.planning import expects  # noqa: PLC0415  (likewise)

    return expects(settings, planned, context)


def _changed(settings: TorqueSettings, given: TorqueSettings) -> TorqueSettings:
    from rigrunner_bearings.torque.contradictions import changed  # noqa: PLC0415  (likewise)

    return changed(settings, given)
