"""Whether the item conforms, given the uncertainty: every limit, and the verdict on the run."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite, nan
from typing import TYPE_CHECKING

from rigrunner.analysis.verdict.chosen import chosen_by
from rigrunner.analysis.verdict.evidence import Judged
from rigrunner.api.verdict import MEAN, Decision, LimitDecision, Limits, Verdict
from rigrunner.signal.coverage import probability_within

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.analysis.verdict.evidence import Evidence
    from rigrunner.analysis.verdict.rule import AppliedRule
    from rigrunner.api.data import Estimate
    from rigrunner.procedure import Acceptance, Limit


def decide(acceptance: Acceptance, rule: AppliedRule, evidence: Evidence) -> Decision:
    """Return what every limit says of the results of a run, by the rule that was agreed."""
    return Decision(
        rule=str(rule),
        rule_in=rule.in_other_languages,
        parts=(
            *_parts(acceptance, rule, evidence),
            *_of_results(acceptance, replace(rule, marginal=0.0), evidence),
        ),
    )


def _of_results(
    acceptance: Acceptance, rule: AppliedRule, evidence: Evidence
) -> Iterator[LimitDecision]:
    """Yield what the limits of named results say."""
    for limit in acceptance.result_limits:
        for chosen in chosen_by(limit, evidence.results):
            found, symbol = chosen.estimate, chosen.unit
            limits = limit.limits_in(symbol)
            problem = chosen.problem or evidence.results_problem
            known = found if found is not None and _uncertainty_is_known(found) else None
            verdict, reason = _verdict(limits, rule, found, problem)
            decided = LimitDecision(
                of=chosen.words,
                named=limit.of,
                verdict=verdict,
                reason=reason,
                limits=limits,
                source=limit.source,
                result=found,
                probability=probability_within(limits, known) if known and not problem else nan,
            )
            yield _with_risks(decided, rule, known)


def _parts(
    acceptance: Acceptance, rule: AppliedRule, evidence: Evidence
) -> Iterator[LimitDecision]:
    if acceptance.mean_limit is not None:
        yield _decided(acceptance.mean_limit, rule, evidence, MEAN, evidence.mean)
    for point in evidence.points:
        limit = acceptance.limit_at(point.set_frequency_hz)
        if limit is not None:
            yield _decided(limit, rule, evidence, f"{point.set_frequency_hz:g} Hz", point)
    measured = [point.set_frequency_hz for point in evidence.points]
    for limit in acceptance.torque_limits:
        missing = [f"{hz:g} Hz" for hz in limit.missing(measured)]
        if limit.of != MEAN and not measured and not limit.at:
            missing = ["each frequency"]
        for name in missing:
            why = evidence.mean.problem or f"there is no result at {name}"
            yield _decided(limit, rule, evidence, name, Judged(None, None, _sentence(why)))


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}" + ("" if text.endswith(".") else ".")


def _decided(
    limit: Limit, rule: AppliedRule, evidence: Evidence, of: str, judged: Judged
) -> LimitDecision:
    limits, found = Limits.between(limit.min, limit.max), judged.compensated
    problem = _objection(limit, evidence) or judged.problem
    verdict, reason = _verdict(limits, rule, found, problem or _no_torque(limits, found))
    known = found if found is not None and _uncertainty_is_known(found) else None
    sure = None if problem else known
    decided = LimitDecision(
        of=of,
        verdict=verdict,
        reason=reason,
        limits=limits,
        source=limit.source,
        result=found,
        probability=probability_within(limits, sure) if sure else nan,
        uncompensated=_verdict(limits, rule, judged.raw, _no_torque(limits, judged.raw))[0],
        marginal=bool(sure and rule.is_marginal(limits, sure)),
        measurand=limit.measurand.kind,
        load_n=limit.measurand.load,
    )
    return _with_risks(decided, rule, known)


def _with_risks(found: LimitDecision, rule: AppliedRule, known: Estimate | None) -> LimitDecision:
    """Return a decision with guard band and risks; without, where the uncertainty is not known."""
    if known is None:
        return found
    limits = found.limits
    return replace(
        found,
        guard_band=rule.guard(limits, known),
        false_accept_risk=rule.false_accept_risk(limits, known),
        false_reject_risk=rule.false_reject_risk(limits, known),
    )


def _objection(limit: Limit, evidence: Evidence) -> str:
    """Return why the limit is not one of this result, as a sentence; '' if it is."""
    if evidence.kind is None:
        return (
            f"{evidence.method} does not say which torque it yields, and the limit is for the "
            f"{limit.measurand}."
        )
    why = limit.measurand.objection(evidence.kind, evidence.loads_n)
    return f"{_sentence(why)[:-1]}: conformity cannot be stated." if why else ""


def _uncertainty_is_known(estimate: Estimate) -> bool:
    return isfinite(estimate.u) and estimate.u > 0


def _no_torque(limits: Limits, estimate: Estimate | None) -> str:
    """Return why a value is no torque of friction, as a sentence; '' where it is one."""
    if estimate is None or estimate.value > 0:
        return ""
    return f"{estimate.value:.4f} {limits.unit} is no friction torque: friction does not drive."


def _verdict(
    limits: Limits, rule: AppliedRule, estimate: Estimate | None, problem: str
) -> tuple[Verdict, str]:
    if problem or estimate is None:
        return Verdict.INCONCLUSIVE, problem or "There is no result."
    if not _uncertainty_is_known(estimate):
        return Verdict.INCONCLUSIVE, "The uncertainty of the result is not known."
    return rule.verdict(limits, estimate)
