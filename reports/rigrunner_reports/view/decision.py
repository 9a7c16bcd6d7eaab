"""The decision on a run: the verdict, with its limit, rule and risk."""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan
from typing import TYPE_CHECKING

from rigrunner.api import Verdict
from rigrunner.api.events import CONCLUDED
from rigrunner.api.units import with_symbol
from rigrunner.api.verdict import probability_text, risk_text, worst
from rigrunner_reports.numbers import fixed, significant, stated
from rigrunner_reports.view.run import moment

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.results import Result
    from rigrunner.api.verdict import Decision, LaterDecision, LimitDecision

SYMBOLS = {
    Verdict.PASS: "✓",
    Verdict.CONDITIONAL_PASS: "(✓)",
    Verdict.INCONCLUSIVE: "?",
    Verdict.CONDITIONAL_FAIL: "(✗)",
    Verdict.FAIL: "✗",
}
NOT_COMPLETED = "A run that was not completed neither passes nor fails."


@dataclass(frozen=True)
class VerdictView:
    """A verdict as symbol and word; `tone` chooses its colour."""

    symbol: str
    word: str

    @property
    def tone(self) -> str:
        """The word as a CSS class."""
        return self.word.replace(" ", "-")


TORQUE = "N·m"
NO_VERDICT = VerdictView("?", "no verdict")


@dataclass(frozen=True)
class LimitView:
    """A limit on a result, ready to print."""

    decision: LimitDecision
    of: str = ""
    """The result, in a table of several limits."""

    @property
    def verdict(self) -> VerdictView:
        """The verdict by the rule."""
        return shown_verdict(self.decision.verdict)

    @property
    def uncompensated(self) -> VerdictView | None:
        """By the same rule, for the raw torque; None for another quantity."""
        raw = self.decision.uncompensated
        return None if raw is None else shown_verdict(raw)

    @property
    def result(self) -> str:
        """The result."""
        return "-" if self.decision.result is None else str(stated(self.decision.result))

    @property
    def probability(self) -> str:
        """The probability of conformity."""
        probability = self.decision.probability
        return "not determined" if isnan(probability) else probability_text(probability)

    @property
    def guard_band(self) -> str:
        """The guard band with its unit; '' if there is none to state."""
        band = self.decision.guard_band
        if isnan(band):
            return ""
        unit = self.decision.limits.unit
        return with_symbol(fixed(band, 4) if unit == TORQUE else significant(band, 3), unit)

    @property
    def measurand(self) -> str:
        """The measurand; '' if the limit has none."""
        return "" if self.decision.measurand is None else str(self.decision.measurand)

    @property
    def risk(self) -> str:
        """The greatest specific risks that the rule implies."""
        risks = []
        if not isnan(self.decision.false_accept_risk):
            risks.append(f"at most {risk_text(self.decision.false_accept_risk)} of a false pass")
        elif not isnan(self.decision.guard_band):
            risks.append("no value could pass")
        if not isnan(self.decision.false_reject_risk):
            risks.append(f"at most {risk_text(self.decision.false_reject_risk)} of a false fail")
        return "; ".join(risks) or "not determined"


@dataclass(frozen=True)
class DecisionView:
    """The decision, ready to print; a run that was not completed has no verdict."""

    decision: Decision
    complete: bool

    @property
    def deciding(self) -> LimitView:
        """The limit that decides."""
        return LimitView(self.decision.deciding)

    @property
    def verdict(self) -> VerdictView:
        """The verdict, if there is one."""
        return self.deciding.verdict if self.complete else NO_VERDICT

    @property
    def reason(self) -> str:
        """The reason, or what the rule would give."""
        if self.complete:
            return self.decision.reason
        would = f"On what was recorded the rule would say: {self.decision.verdict}."
        return f"{NOT_COMPLETED} {would} {self.decision.reason}"

    @property
    def all_named(self) -> bool:
        """Whether every limit applies to a named result, which has its own table."""
        return all(part.uncompensated is None for part in self.decision.parts)

    @property
    def parts(self) -> tuple[LimitView, ...]:
        """Every limit, if there are several."""
        if len(self.decision.parts) == 1:
            return ()
        return tuple(LimitView(part, self.decision.words(part)) for part in self.decision.parts)


@dataclass(frozen=True)
class OverallView:
    """The verdict on the run, ready to print: on its measured values and by the decision."""

    verdict: VerdictView
    reasons: tuple[str, ...]
    """A sentence for each of the two, if present."""


def overall(result: Result, latest: Sequence[LaterDecision]) -> OverallView | None:
    """Return the verdict in force, by the latest decision; None without a decision."""
    if result.run.outcome not in CONCLUDED:
        return None if result.decision is None else OverallView(NO_VERDICT, ())
    by_decision = result.decision.verdict if result.decision else None
    if latest:
        by_decision = Verdict(latest[-1].verdict)
    verdict = worst((result.limits.verdict, by_decision))
    if verdict is None:
        return None
    reasons = [result.limits.reason] if result.limits.verdict else []
    if result.decision and not latest:
        by = f"By the limits of the result: {result.decision.verdict}. " if reasons else ""
        reasons.append(by + result.decision.reason)
    return OverallView(shown_verdict(verdict), tuple(reasons))


@dataclass(frozen=True)
class LaterView:
    """A later decision, ready to print."""

    decision: LaterDecision

    @property
    def when(self) -> str:
        """The time, to the second."""
        return moment(self.decision.decided_utc)

    @property
    def verdict(self) -> VerdictView:
        """The verdict."""
        return shown_verdict(Verdict(self.decision.verdict))


def shown_verdict(verdict: Verdict) -> VerdictView:
    """Return a verdict as symbol and word."""
    return VerdictView(SYMBOLS[verdict], str(verdict))
