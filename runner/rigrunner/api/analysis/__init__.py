"""The contracts of the analysis: budgets and checks, outlier rules, fits, and what is required."""

from typing import Any

from rigrunner.api.analysis.budget import Bias, Check, Component, Consequence
from rigrunner.api.analysis.curves import (
    Candidate,
    Chosen,
    Curve,
    Fit,
    Spreading,
)
from rigrunner.api.analysis.requirements import NeededChannel, NeededResult, NeededRun, Requirements
from rigrunner.api.analysis.rules import (
    OutlierRule,
    Rejection,
)
from rigrunner.moved import moved

__all__ = [
    "Bias",
    "Candidate",
    "Check",
    "Chosen",
    "Component",
    "Consequence",
    "Curve",
    "Fit",
    "NeededChannel",
    "NeededResult",
    "NeededRun",
    "OutlierRule",
    "Rejection",
    "Requirements",
    "Spreading",
]


def __getattr__(name: str) -> Any:
    """Return a name that has moved to another package; raise AttributeError for any other."""
    return moved(__name__, name)
