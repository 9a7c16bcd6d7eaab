"""Records of the analyses of torque: names, requirements, results. Nothing here loads numpy."""

from __future__ import annotations

from dataclasses import replace

from rigrunner.api import AnalysisRecord, Imported, hookimpl

_LIMIT = "rigrunner_bearings.api.measurand:LimitMeasurand"
_SETTINGS = "rigrunner_bearings.torque.settings"
_RECORDINGS = "rigrunner_bearings.conformance.recordings"


@hookimpl
def rigrunner_analyses() -> list[AnalysisRecord]:
    """Return the analyses of torque."""
    swings = AnalysisRecord(
        name="swing_torque",
        help="Torque at the reversals of swings, from recordings or from measured values",
        settings=f"{_SETTINGS}:SwingTorque",
        measurand="torque",
        limit_measurand=_LIMIT,
        factory=Imported("rigrunner_bearings.torque.analysis:TorqueAnalysis"),
        yields=Imported("rigrunner_bearings.torque.definition:definitions"),
        requires=Imported("rigrunner_bearings.torque.definition:requirements"),
        partner_problems=Imported("rigrunner_bearings.torque.planning:partner_problems"),
        plan_problems=Imported("rigrunner_bearings.torque.planning:plan_problems"),
        entering=Imported("rigrunner_bearings.torque.planning:entering"),
        expects=Imported("rigrunner_bearings.torque.planning:expects"),
        live=Imported("rigrunner_bearings.torque.live:LiveTorque"),
        changed=Imported("rigrunner_bearings.torque.contradictions:changed"),
        in_context=True,
        trial={
            "despike": {"hampel": {"window": 11}},
            "outliers": {"grubbs": {"alpha": 0.05}},
            "fits": [{"polynomial": {"degree": 2}}],
            "no_load": {"from": "latest", "procedure": "SSPB-NLI"},
            "compensations": ["peak_same_frequency"],
        },
        trial_run=f"{_RECORDINGS}:run_of_swings",
    )
    starts = replace(
        swings,
        name="breakaway",
        help="Torque at the first movement: every recording is a start from rest",
        settings=f"{_SETTINGS}:Breakaway",
        live=None,
        trial={"outliers": {"grubbs": {"alpha": 0.05}}, "compensations": ["breakaway_peak"]},
        trial_run=f"{_RECORDINGS}:run_of_starts",
    )
    return [swings, starts]
