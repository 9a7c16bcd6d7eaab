"""From procedure and station to explicit steps."""

from __future__ import annotations

from rigrunner.plan.actions import Plan, PlannedStep
from rigrunner.plan.analyses import check_analyses
from rigrunner.plan.limits import check_limits
from rigrunner.plan.making import check_station, make_plan, plan_text
from rigrunner.plan.partners import check_partners
from rigrunner.plan.plugins import check_plugins, check_rule, check_station_plugins
from rigrunner.plan.prediction import PredictedTorque, Prediction, predict
from rigrunner.plan.requirements import check_requirements

__all__ = [
    "Plan",
    "PlannedStep",
    "PredictedTorque",
    "Prediction",
    "check_analyses",
    "check_limits",
    "check_partners",
    "check_plugins",
    "check_requirements",
    "check_rule",
    "check_station",
    "check_station_plugins",
    "make_plan",
    "plan_text",
    "predict",
]
