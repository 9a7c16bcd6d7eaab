"""What was decided on a run: the verdict, by which limit and rule, and at what risk."""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan
from typing import TYPE_CHECKING

from rigrunner.api.events import CONCLUDED
from rigrunner.api.verdict import Verdict, probability_text, worst
from rigrunner_reports.numbers import fixed, stated

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

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
MARGINAL = "Marginal: a difference within the marginal band would change the verdict."


@dataclass(frozen=True)
class VerdictView:
    """A verdict as symbol and word; `tone` chooses its colour."""

    symbol: str
    word: str

    @property
    def tone(self) -> str:
        """The word as a CSS class."""
        return self.word.replace(" ", "-")


NO_VERDICT = VerdictView("?", "no verdict")


@dataclass(frozen=True)
class PartRow:
    """One limit among several, ready to print."""

    of: str
    result: str
    limit: str
    verdict: VerdictView
    probability: str
    uncompensated: VerdictView
    marginal: bool


@dataclass(frozen=True)
class LaterView:
    """A later decision, ready to print."""

    when: str
    verdict: VerdictView
    words: str
    before: str
    file: str


@dataclass(frozen=True)
class DecisionView:
    """The decision, ready to print."""

    verdict: VerdictView
    uncompensated: VerdictView
    reason: str
    limit: str
    source: str
    measurand: str
    rule: str
    guard_band: str
    risk: str
    probability: str
    marginal: str
    parts: tuple[PartRow, ...]


def decision(found: Decision | None, *, complete: bool) -> DecisionView | None:
    """Return the decision, ready to print; of a run that was not completed there is no verdict."""
    if found is None:
        return None
    stopped = f"{NOT_COMPLETED} On what was recorded the rule would say: {found.verdict}. "
    several = len(found.parts) > 1
    return DecisionView(
        verdict=shown_verdict(found.verdict) if complete else NO_VERDICT,
        uncompensated=shown_verdict(found.uncompensated),
        reason=found.reason if complete else stopped + found.reason,
        limit=found.limit_text,
        source=found.limit_source,
        measurand=_measurand(found),
        rule=found.rule,
        guard_band="" if isnan(found.guard_band_nm) else f"{fixed(found.guard_band_nm, 4)} N·m",
        risk=_risk(found),
        probability=_percent(found.probability_of_conformity),
        marginal=MARGINAL if found.marginal else "",
        parts=tuple(map(_part, found.parts)) if several else (),
    )


@dataclass(frozen=True)
class OverallView:
    """The verdict on the run, ready to print: of its measured values and of the decision."""

    verdict: VerdictView
    reasons: tuple[str, ...]
    """A sentence for each of the two that there is."""


def overall(result: Result, latest: Sequence[LaterDecision]) -> OverallView | None:
    """Return the verdict in force, by the latest decision; None where nothing is decided."""
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


def later(found: Sequence[LaterDecision]) -> tuple[LaterView, ...]:
    """Return the later decisions, ready to print."""
    return tuple(
        LaterView(
            when=each.decided_utc[:19].replace("T", " "),
            verdict=shown_verdict(Verdict(each.verdict)),
            words=f"{each.reason} Rule: {each.rule}. Limit: {each.limit_text} "
            f"({each.limit_source}). Decided by {each.by}: {each.why}",
            before=f"{each.verdict_before}; {each.rule_before}; {each.limit_before}",
            file=each.file,
        )
        for each in found
    )


def _part(found: LimitDecision) -> PartRow:
    return PartRow(
        of=found.of,
        result="-" if found.result is None else str(stated(found.result)),
        limit=found.limit_text,
        verdict=shown_verdict(found.verdict),
        probability=_percent(found.probability_of_conformity),
        uncompensated=shown_verdict(found.uncompensated),
        marginal=found.marginal,
    )


def _measurand(found: Decision) -> str:
    if found.measurand is None:
        return ""
    load = "" if found.load_n is None else f" under {found.load_n:g} N"
    return f"{found.measurand}{load}"


def _risk(found: Decision) -> str:
    """Return the greatest specific risks that the rule implies, in words."""
    return "; ".join(_risks(found)) or "not determined"


def _risks(found: Decision) -> Iterator[str]:
    if not isnan(found.stated_risk):
        yield f"at most {_percent(found.stated_risk)} of a false pass"
    elif not isnan(found.guard_band_nm):
        yield "no value could pass"
    if not isnan(found.false_reject_risk):
        yield f"at most {_percent(found.false_reject_risk)} of a false fail"


def shown_verdict(found: Verdict) -> VerdictView:
    """Return a verdict as symbol and word."""
    return VerdictView(SYMBOLS[found], str(found))


def _percent(value: float) -> str:
    return "not determined" if isnan(value) else probability_text(value)
