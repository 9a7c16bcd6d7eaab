"""The result of an analysis: what the report shows and `result.json` carries."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from math import inf, nan
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.analysis import Check, Compensation, Component, Curve, PeakPoint
    from rigrunner.api.data import Estimate, Points, RunData
    from rigrunner.api.measurand import MeasurandKind
    from rigrunner.api.validation import Validation

MEAN = "mean"
"""What is judged where not a single set-point is: the mean over all of them."""


REPLAYED = "replayed"
"""The name in a run's provenance that says from which tape it is: no instrument was asked."""

CERTAIN = 0.9999
"""A probability beyond this is not printed as a number: it would look like certainty."""


def probability_text(probability: float) -> str:
    """Return a probability in per cent, without a false 0 or 100."""
    if probability > CERTAIN:
        return "> 99.99 %"
    return "< 0.01 %" if probability < 1 - CERTAIN else f"{100 * probability:.2f} %"


class Verdict(StrEnum):
    """What was decided; a run without limits has none."""

    PASS = "pass"  # noqa: S105  (a verdict, not a password)
    CONDITIONAL_PASS = "conditional pass"  # noqa: S105  (a verdict, not a password)
    INCONCLUSIVE = "inconclusive"
    CONDITIONAL_FAIL = "conditional fail"
    FAIL = "fail"


@dataclass(frozen=True, kw_only=True)
class LimitDecision:
    """What one limit says of one result, with all that is needed to understand it."""

    of: str = MEAN
    """What is judged: 'mean', or one set-point, such as '35 Hz'."""
    verdict: Verdict
    reason: str
    """One sentence."""
    limit_text: str
    limit_source: str
    lower_nm: float = -inf
    upper_nm: float = inf
    """The limits in N·m; infinite where there is none."""
    result: Estimate | None = None
    """What was judged; None where there is nothing to judge."""
    guard_band_nm: float = nan
    """w in N·m: a result passes that is within the limit by at least w; nan where unknown."""
    stated_risk: float = nan
    """The highest probability that an item which this rule passes does not conform.

    The specific risk of false acceptance, for this uncertainty (JCGM 106, 3.3.13); nan where
    unknown, or where no result could pass.
    """
    false_reject_risk: float = nan
    """The highest probability that an item which this rule fails conforms."""
    probability_of_conformity: float
    """That the true value is within the limits (JCGM 106, 7); nan where unknown."""
    uncompensated: Verdict
    """What the same rule would say of the raw torque."""
    marginal: bool = False
    """Whether a result different by no more than the marginal band had another verdict."""
    measurand: MeasurandKind | None = None
    """What the limit is a limit of."""
    load_n: float | None = None
    """The load that the limit is for, where it names one."""


@dataclass(frozen=True, kw_only=True)
class Decision(LimitDecision):
    """The verdict on a run: that of the limit that decides, and all the others beside it."""

    rule: str
    """The rule with its words: 'simple: ...'."""
    parts: tuple[LimitDecision, ...] = ()
    """Every limit on the mean and on the set-points, the deciding one among them."""


@dataclass(frozen=True, kw_only=True)
class LaterDecision:
    """A stored run decided again by another rule or limit, as put on record beside it."""

    file: str
    decided_utc: str
    by: str
    why: str
    """The reason that was given for deciding again."""
    verdict: str
    reason: str
    rule: str
    limit_text: str
    limit_source: str
    verdict_before: str
    """What held until then; 'none' where nothing had been decided."""
    rule_before: str
    limit_before: str


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
    headline_components: tuple[Component, ...] = ()
    """Its budget: what the points have in common enters once, the rest averaged."""
    raw_headline: Estimate | None = None
    """The same mean of the raw torque."""
    decision: Decision | None = None
    validation: Validation | None = None
    """The Monte Carlo check of the headline, where the procedure asks for one."""
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
    """Answers, alarms and interventions, each with 'utc', 'kind' and 'text'; the kind of an
    intervention is its action, such as 'override'."""
    later_decisions: tuple[LaterDecision, ...] = ()
    """By another rule or limit than the run was made for, oldest first."""
