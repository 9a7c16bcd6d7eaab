"""Runs a plan on a rig, emits events, always makes safe."""

from rigrunner.engine.answers import AnswerSource, UnattendedAnswers
from rigrunner.engine.run import RunSummary, run_plan

__all__ = ["AnswerSource", "RunSummary", "UnattendedAnswers", "run_plan"]
