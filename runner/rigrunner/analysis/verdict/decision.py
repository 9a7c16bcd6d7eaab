"""Whether the item conforms, given the uncertainty: every limit, and the verdict on the run."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite, nan
from typing import TYPE_CHECKING

from rigrunner.analysis.verdict.limited_values import limited_values
from rigrunner.api.errors import DataError
from rigrunner.api.verdict import Decision, LimitDecision, Limits, Verdict
from rigrunner.signal.coverage import probability_within

if TYPE_CHECKING:
    from rigrunner.analysis.verdict.evidence import Evidence
    from rigrunner.analysis.verdict.limited_values import LimitedValue
    from rigrunner.analysis.verdict.rule import AppliedRule
    from rigrunner.api.data import Estimate
    from rigrunner.api.details import AnalysisDetails
    from rigrunner.procedure import Acceptance, Limit


def decide(acceptance: Acceptance, rule: AppliedRule, evidence: Evidence) -> Decision:
    """Return the decision of every limit on the results of a run, by the agreed rule.

    Limits of one result are listed together, those of its mean first, then in the order of the run.
    """
    names = list(dict.fromkeys(limit.of for limit in acceptance.limits))
    parts: list[tuple[int, int, LimitDecision]] = []
    for limit in acceptance.limits:
        values = limited_values(limit, evidence)
        decisions = [(v.order, _limit_decision(limit, rule, evidence, v)) for v in values]
        if limit.worst:
            part = min((part for _, part in decisions), key=lambda decision: decision.badness)
            place = ", ".join(f"{name} = {value}" for name, value in part.coordinates.items())
            of = f"worst {limit.of} at {place}" if place else f"worst {limit.of}"
            decisions = [(-1, replace(part, of=of)), *(decisions if limit.each else ())]
        parts += [(names.index(limit.of), *entry) for entry in decisions]
    parts.sort(key=lambda part: part[:2])
    return Decision(
        rule=str(rule), rule_in=rule.in_other_languages, parts=tuple(part for *_, part in parts)
    )


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}" + ("" if text.endswith(".") else ".")


def _limit_decision(
    limit: Limit, rule: AppliedRule, evidence: Evidence, value: LimitedValue
) -> LimitDecision:
    estimate, details = value.estimate, evidence.details.get(limit.of)
    no_limits = ""
    try:
        limits = limit.limits_at(value.coordinates, value.unit)
    except DataError as error:
        limits = Limits.between(None, None, value.unit)
        # Without a result, that is the reason, not the missing limits.
        no_limits = "" if estimate is None else _sentence(error.message)
    problem = details.objection(limit.measurand) if details else _objection(limit, evidence)
    problem = problem or value.problem or evidence.problem(limit, value.coordinates) or no_limits
    impossible = _impossible(details, limits, estimate)
    verdict, reason = _verdict(limits, rule, estimate, problem or impossible)
    usable = estimate if estimate and _uncertainty_is_known(estimate) and not no_limits else None
    # A problem puts the value in doubt, so no probability is stated. Guard band and risks stay:
    # they depend on the uncertainty alone.
    valid = None if problem else usable
    uncompensated = None
    if details and details.corrects:
        impossible = _impossible(details, limits, value.uncorrected)
        uncompensated, _ = _verdict(limits, rule, value.uncorrected, impossible)
    return LimitDecision(
        of=value.words,
        named=limit.of,
        verdict=verdict,
        reason=reason,
        limits=limits,
        source=limit.source,
        result=estimate,
        coordinates=value.coordinates,
        guard_band=rule.guard(limits, usable) if usable else nan,
        false_accept_risk=rule.false_accept_risk(limits, usable) if usable else nan,
        false_reject_risk=rule.false_reject_risk(limits, usable) if usable else nan,
        probability=probability_within(limits, valid) if valid else nan,
        uncompensated=uncompensated,
        marginal=bool(valid and rule.is_marginal(limits, valid)),
        measurand=limit.measurand,
    )


def _objection(limit: Limit, evidence: Evidence) -> str:
    """Return why a limit is for another measurand than that of the results, as a sentence."""
    results = (*evidence.results, *evidence.means)
    definition = next((result.of for result in results if result.name == limit.of), None)
    if definition is None or definition.measurand is None:
        return ""
    message, _ = limit.objection_to(definition)
    return _sentence(message) if message else ""


def _uncertainty_is_known(estimate: Estimate) -> bool:
    return isfinite(estimate.u) and estimate.u > 0


def _impossible(details: AnalysisDetails | None, limits: Limits, estimate: Estimate | None) -> str:
    if details is None or estimate is None:
        return ""
    return details.impossible(estimate.value, limits.unit)


def _verdict(
    limits: Limits, rule: AppliedRule, estimate: Estimate | None, problem: str
) -> tuple[Verdict, str]:
    if problem or estimate is None:
        return Verdict.INCONCLUSIVE, problem or "There is no result."
    if not _uncertainty_is_known(estimate):
        return Verdict.INCONCLUSIVE, "The uncertainty of the result is not known."
    return rule.verdict(limits, estimate)
