"""Whether the item conforms, given the uncertainty: every limit, and the verdict on the run."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite, nan
from typing import TYPE_CHECKING

from rigrunner.analysis.verdict.chosen import chosen_by
from rigrunner.api.errors import DataError
from rigrunner.api.verdict import Decision, LimitDecision, Limits, Verdict
from rigrunner.signal.coverage import probability_within

if TYPE_CHECKING:
    from rigrunner.analysis.verdict.chosen import Chosen
    from rigrunner.analysis.verdict.evidence import Evidence
    from rigrunner.analysis.verdict.rule import AppliedRule
    from rigrunner.api.data import Estimate
    from rigrunner.api.details import AnalysisDetails
    from rigrunner.procedure import Acceptance, Limit


def decide(acceptance: Acceptance, rule: AppliedRule, evidence: Evidence) -> Decision:
    """Return what every limit says of the results of a run, by the rule that was agreed.

    Limits of one result stand together, those of its mean first, then in the order of the run.
    """
    names = list(dict.fromkeys(limit.of for limit in acceptance.limits))
    parts: list[tuple[int, int, LimitDecision]] = []
    for limit in acceptance.limits:
        decisions = [
            (chosen.order, _decided(limit, rule, evidence, chosen))
            for chosen in chosen_by(limit, evidence)
        ]
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


def _decided(limit: Limit, rule: AppliedRule, evidence: Evidence, chosen: Chosen) -> LimitDecision:
    estimate, details = chosen.estimate, evidence.details.get(limit.of)
    no_limits = ""
    try:
        limits = limit.limits_at(chosen.coordinates, chosen.unit)
    except DataError as error:
        limits = Limits.between(None, None, chosen.unit)
        # Where there is no result, that is the reason, and not what its limits lack.
        no_limits = "" if estimate is None else _sentence(error.message)
    problem = details.objection(limit.measurand) if details else _objection(limit, evidence)
    problem = problem or chosen.problem or evidence.problem(limit, chosen.coordinates) or no_limits
    impossible = _impossible(details, limits, estimate)
    verdict, reason = _verdict(limits, rule, estimate, problem or impossible)
    usable = None
    if estimate is not None and _uncertainty_is_known(estimate) and not no_limits:
        usable = estimate
    # A problem puts the value in doubt, so no probability is stated. Guard band and risks stay:
    # they depend on the uncertainty alone.
    stated = None if problem else usable
    uncompensated = None
    if details and details.corrects:
        impossible = _impossible(details, limits, chosen.uncorrected)
        uncompensated, _ = _verdict(limits, rule, chosen.uncorrected, impossible)
    return LimitDecision(
        of=chosen.words,
        named=limit.of,
        verdict=verdict,
        reason=reason,
        limits=limits,
        source=limit.source,
        result=estimate,
        coordinates=chosen.coordinates,
        guard_band=rule.guard(limits, usable) if usable else nan,
        false_accept_risk=rule.false_accept_risk(limits, usable) if usable else nan,
        false_reject_risk=rule.false_reject_risk(limits, usable) if usable else nan,
        probability=probability_within(limits, stated) if stated else nan,
        uncompensated=uncompensated,
        marginal=bool(stated and rule.is_marginal(limits, stated)),
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
