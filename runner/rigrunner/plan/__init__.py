"""From procedure and station to explicit steps."""

from __future__ import annotations

from rigrunner.plan.actions import Plan, PlannedStep
from rigrunner.plan.analyses import check_analyses
from rigrunner.plan.making import check_station, make_plan, plan_text
from rigrunner.plan.partners import check_partners
from rigrunner.plan.plugins import check_plugins, check_rule, check_station_plugins
from rigrunner.plan.prediction import PredictedReading, Prediction, predict
from rigrunner.plan.register import check_register
from rigrunner.plan.reviewing import check_plan, expected_readings, run_to_come

__all__ = [
    "Plan",
    "PlannedStep",
    "PredictedReading",
    "Prediction",
    "check_analyses",
    "check_partners",
    "check_plan",
    "check_plugins",
    "check_register",
    "check_rule",
    "check_station",
    "check_station_plugins",
    "expected_readings",
    "make_plan",
    "plan_text",
    "predict",
    "run_to_come",
]
