"""The result of an analysis: what the report shows and `result.json` carries."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from math import inf
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.analysis import Check, Compensation, Curve, PeakPoint
    from rigrunner.api.data import Estimate, Points, RunData


class Verdict(StrEnum):
    """What was decided; a run without limits has none."""

    PASS = "pass"  # noqa: S105  (a verdict, not a password)
    CONDITIONAL_PASS = "conditional pass"  # noqa: S105  (a verdict, not a password)
    INCONCLUSIVE = "inconclusive"
    CONDITIONAL_FAIL = "conditional fail"
    FAIL = "fail"


@dataclass(frozen=True)
class Decision:
    """The verdict with all that is needed to understand it."""

    verdict: Verdict
    reason: str
    limit_text: str
    limit_source: str
    rule: str
    probability_of_conformity: float
    uncompensated: Verdict
    """What the same rule would say of the raw torque."""
    lower_nm: float = -inf
    upper_nm: float = inf
    """The limits in N·m, for a plot; infinite where there is none."""


@dataclass(frozen=True, eq=False)
class FittedTorque:
    """A fit of the no-load peaks over frequency, by its name in the procedure."""

    name: str
    points: Points
    curve: Curve | None
    problem: str = ""
    """Why the fit could not be made."""


@dataclass(frozen=True, eq=False)
class Result:
    """The outcome of the one analysis that serves online, stored and batch."""

    run: RunData
    no_load_run: RunData | None
    measurand: str
    symbol: str
    loaded: tuple[PeakPoint, ...]
    """The points of this run; of a no-load run, its own."""
    no_load: tuple[PeakPoint, ...]
    fits: tuple[FittedTorque, ...]
    compensations: Mapping[str, Compensation]
    primary: str = ""
    headline: Estimate | None = None
    """The mean over the set-points by the primary method."""
    raw_headline: Estimate | None = None
    """The same mean of the raw torque."""
    decision: Decision | None = None
    checks: tuple[Check, ...] = ()
    notes: tuple[str, ...] = ()
    settings: Mapping[str, object] = field(default_factory=dict)
    """The analysis as it was asked for, resolved to defaults."""


@dataclass(frozen=True, eq=False)
class ReportInput:
    """What a report format is given."""

    result: Result
    document: Mapping[str, object]
    """The content of `result.json`: the same numbers, with units."""
    truth: Mapping[str, Mapping[str, float]]
    """Of a simulated rig, by recording; empty on a real one."""
    provenance: Mapping[str, str]
    """Program and package versions, files and digests, as printed on the report's last page."""
    events: tuple[Mapping[str, str], ...] = ()
    """Answers, alarms and interventions, each with 'utc', 'kind' and 'text'."""
