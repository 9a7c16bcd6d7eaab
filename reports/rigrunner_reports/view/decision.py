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

    found: LimitDecision
    of: str = ""
    """The result, in a table of several limits."""

    @property
    def verdict(self) -> VerdictView:
        """The verdict by the rule."""
        return shown_verdict(self.found.verdict)

    @property
    def uncompensated(self) -> VerdictView | None:
        """By the same rule, for the raw torque; None for another quantity."""
        raw = self.found.uncompensated
        return None if raw is None else shown_verdict(raw)

    @property
    def result(self) -> str:
        """The result."""
        return "-" if self.found.result is None else str(stated(self.found.result))

    @property
    def probability(self) -> str:
        """The probability of conformity."""
        found = self.found.probability
        return "not determined" if isnan(found) else probability_text(found)

    @property
    def guard_band(self) -> str:
        """The guard band with its unit; '' if there is none to state."""
        band = self.found.guard_band
        if isnan(band):
            return ""
        unit = self.found.limits.unit
        return with_symbol(fixed(band, 4) if unit == TORQUE else significant(band, 3), unit)

    @property
    def measurand(self) -> str:
        """The measurand; '' if the limit has none."""
        return "" if self.found.measurand is None else str(self.found.measurand)

    @property
    def risk(self) -> str:
        """The greatest specific risks that the rule implies."""
        risks = []
        if not isnan(self.found.false_accept_risk):
            risks.append(f"at most {risk_text(self.found.false_accept_risk)} of a false pass")
        elif not isnan(self.found.guard_band):
            risks.append("no value could pass")
        if not isnan(self.found.false_reject_risk):
            risks.append(f"at most {risk_text(self.found.false_reject_risk)} of a false fail")
        return "; ".join(risks) or "not determined"


@dataclass(frozen=True)
class DecisionView:
    """The decision, ready to print; a run that was not completed has no verdict."""

    found: Decision
    complete: bool

    @property
    def deciding(self) -> LimitView:
        """The limit that decides."""
        return LimitView(self.found.deciding)

    @property
    def verdict(self) -> VerdictView:
        """The verdict, if there is one."""
        return self.deciding.verdict if self.complete else NO_VERDICT

    @property
    def reason(self) -> str:
        """The reason, or what the rule would give."""
        if self.complete:
            return self.found.reason
        would = f"On what was recorded the rule would say: {self.found.verdict}."
        return f"{NOT_COMPLETED} {would} {self.found.reason}"

    @property
    def all_named(self) -> bool:
        """Whether every limit applies to a named result, which has its own table."""
        return all(part.uncompensated is None for part in self.found.parts)

    @property
    def parts(self) -> tuple[LimitView, ...]:
        """Every limit, if there are several."""
        if len(self.found.parts) == 1:
            return ()
        return tuple(LimitView(each, self.found.words(each)) for each in self.found.parts)


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
    decided = result.decision.verdict if result.decision else None
    if latest:
        decided = Verdict(latest[-1].verdict)
    found = worst((result.limits.verdict, decided))
    if found is None:
        return None
    reasons = [result.limits.reason] if result.limits.verdict else []
    if result.decision and not latest:
        by = f"By the limits of the result: {result.decision.verdict}. " if reasons else ""
        reasons.append(by + result.decision.reason)
    return OverallView(shown_verdict(found), tuple(reasons))


@dataclass(frozen=True)
class LaterView:
    """A later decision, ready to print."""

    found: LaterDecision

    @property
    def when(self) -> str:
        """The time, to the second."""
        return moment(self.found.decided_utc)

    @property
    def verdict(self) -> VerdictView:
        """The verdict."""
        return shown_verdict(Verdict(self.found.verdict))


def shown_verdict(found: Verdict) -> VerdictView:
    """Return a verdict as symbol and word."""
    return VerdictView(SYMBOLS[found], str(found))
