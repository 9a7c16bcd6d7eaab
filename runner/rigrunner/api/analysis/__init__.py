"""The contracts of the analysis: outlier rules, fits and compensations."""

from rigrunner.api.analysis.compensation import (
    Bias,
    Check,
    CompensatedPoint,
    Compensation,
    CompensationMethod,
    Component,
    Consequence,
    Sweep,
    SwingSweep,
    Trace,
)
from rigrunner.api.analysis.curves import (
    Candidate,
    Chosen,
    Curve,
    Fit,
    Spreading,
)
from rigrunner.api.analysis.points import (
    MotionSource,
    PeakPoint,
    StartPoint,
    SwingPoint,
)
from rigrunner.api.analysis.requirements import NeededChannel, NeededResult, NeededRun, Requirements
from rigrunner.api.analysis.rules import (
    OutlierRule,
    Rejection,
)

__all__ = [
    "Bias",
    "Candidate",
    "Check",
    "Chosen",
    "CompensatedPoint",
    "Compensation",
    "CompensationMethod",
    "Component",
    "Consequence",
    "Curve",
    "Fit",
    "MotionSource",
    "NeededChannel",
    "NeededResult",
    "NeededRun",
    "OutlierRule",
    "PeakPoint",
    "Rejection",
    "Requirements",
    "Spreading",
    "StartPoint",
    "Sweep",
    "SwingPoint",
    "SwingSweep",
    "Trace",
]
