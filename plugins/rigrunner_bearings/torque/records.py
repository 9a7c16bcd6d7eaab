"""What the analyses of torque are called, need and yield. Nothing here loads numpy."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import AnalysisRecord, hookimpl

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api import AnalysisContext, Requirements, ResultDefinition, RunData
    from rigrunner.api.partners import PlannedRun
    from rigrunner.procedure import AnalysisSpec
    from rigrunner_bearings.torque.analysis import TorqueAnalysis

SETTINGS = "rigrunner.procedure.analysis_spec:AnalysisSpec"
_RECORDINGS = "rigrunner_bearings.conformance.recordings"


@hookimpl
def rigrunner_analyses() -> list[AnalysisRecord]:
    """Return the analyses of torque."""
    return [
        AnalysisRecord(
            name="swing_torque",
            help="Torque at the reversals of swings, from recordings or from measured values",
            settings=SETTINGS,
            factory=_analysis,
            yields=_definitions,
            requires=_requirements,
            partner_problems=_partner_problems,
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
            settings=SETTINGS,
            factory=_analysis,
            yields=_definitions,
            requires=_requirements,
            partner_problems=_partner_problems,
            in_context=True,
            trial={
                "starts": {},
                "outliers": {"grubbs": {"alpha": 0.05}},
                "compensations": ["breakaway_peak"],
            },
            trial_run=f"{_RECORDINGS}:run_of_starts",
        ),
    ]


def _analysis(settings: AnalysisSpec, context: AnalysisContext) -> TorqueAnalysis:
    from rigrunner_bearings.torque.analysis import TorqueAnalysis  # noqa: PLC0415  (numpy)

    return TorqueAnalysis(settings, context)


def _definitions(settings: AnalysisSpec, context: AnalysisContext) -> tuple[ResultDefinition, ...]:
    from rigrunner_bearings.torque.definition import definitions  # noqa: PLC0415  (likewise)

    return definitions(settings, context)


def _requirements(settings: AnalysisSpec, context: AnalysisContext) -> Requirements:
    from rigrunner_bearings.torque.definition import requirements  # noqa: PLC0415  (likewise)

    return requirements(settings, context)


def _partner_problems(
    settings: AnalysisSpec, planned: PlannedRun, partner: RunData
) -> Iterator[str]:
    from rigrunner_bearings.torque.partner import partner_problems  # noqa: PLC0415  (numpy)

    del settings
    return partner_problems(planned, partner)
