"""Runs a plan on a rig, emits events, always makes safe."""

from rigrunner.engine.answers import AnswerSource, UnattendedAnswers
from rigrunner.engine.by_hand import run_by_hand
from rigrunner.engine.overrides import Override
from rigrunner.engine.pausing import Choice, Decision, Interference, Paused, Pauses, StopNow
from rigrunner.engine.run import RunSummary, run_plan
from rigrunner.engine.seam import Seam, brought_back, find_seam, passed_over, streams_before

__all__ = [
    "AnswerSource",
    "Choice",
    "Decision",
    "Interference",
    "Override",
    "Paused",
    "Pauses",
    "RunSummary",
    "Seam",
    "StopNow",
    "UnattendedAnswers",
    "brought_back",
    "find_seam",
    "passed_over",
    "run_by_hand",
    "run_plan",
    "streams_before",
]
