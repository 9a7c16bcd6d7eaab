"""Runs a plan on a rig, emits events, always makes safe."""

from rigrunner.engine.answers import AnswerSource, UnattendedAnswers
from rigrunner.engine.by_hand import run_by_hand
from rigrunner.engine.pausing import (
    Choice,
    Decision,
    Interference,
    Override,
    Paused,
    Pauses,
    StopNow,
)
from rigrunner.engine.resume_point import (
    ResumePoint,
    find_resume_point,
    passed_over,
    restoring_step,
    streams_before,
)
from rigrunner.engine.run import RunSummary, run_plan

__all__ = [
    "AnswerSource",
    "Choice",
    "Decision",
    "Interference",
    "Override",
    "Paused",
    "Pauses",
    "ResumePoint",
    "RunSummary",
    "StopNow",
    "UnattendedAnswers",
    "find_resume_point",
    "passed_over",
    "restoring_step",
    "run_by_hand",
    "run_plan",
    "streams_before",
]
