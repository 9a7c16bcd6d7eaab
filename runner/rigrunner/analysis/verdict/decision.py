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
    names = list(dict.fromkeys(each.of for each in acceptance.limits))
    parts: list[tuple[int, int, LimitDecision]] = []
    for limit in acceptance.limits:
        chosen = list(chosen_by(limit, evidence))
        found = [(each.order, _decided(limit, rule, evidence, each)) for each in chosen]
        if limit.worst:
            part = min((part for _, part in found), key=lambda each: each.badness)
            place = ", ".join(f"{name} = {value}" for name, value in part.coordinates.items())
            of = f"worst {limit.of} at {place}" if place else f"worst {limit.of}"
            found = [(-1, replace(part, of=of)), *(found if limit.each else ())]
        parts += [(names.index(limit.of), *each) for each in found]
    parts.sort(key=lambda each: each[:2])
    return Decision(
        rule=str(rule), rule_in=rule.in_other_languages, parts=tuple(each for *_, each in parts)
    )


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}" + ("" if text.endswith(".") else ".")


def _decided(limit: Limit, rule: AppliedRule, evidence: Evidence, chosen: Chosen) -> LimitDecision:
    found, details = chosen.estimate, evidence.details.get(limit.of)
    without = ""
    try:
        limits = limit.limits_at(chosen.coordinates, chosen.unit)
    except DataError as error:
        limits = Limits.between(None, None, chosen.unit)
        # Where there is no result, that is the reason, and not what its limits lack.
        without = "" if found is None else _sentence(error.message)
    problem = details.objection(limit.measurand) if details else _objection(limit, evidence)
    problem = problem or chosen.problem or evidence.problem(limit, chosen.coordinates) or without
    impossible = _impossible(details, limits, found)
    verdict, reason = _verdict(limits, rule, found, problem or impossible)
    known = found if found is not None and _uncertainty_is_known(found) and not without else None
    # A problem puts the value in doubt, so no probability is stated. Guard band and risks stay:
    # they depend on the uncertainty alone.
    sure = None if problem else known
    raw = None
    if details and details.corrects:
        impossible = _impossible(details, limits, chosen.uncorrected)
        raw, _ = _verdict(limits, rule, chosen.uncorrected, impossible)
    return LimitDecision(
        of=chosen.words,
        named=limit.of,
        verdict=verdict,
        reason=reason,
        limits=limits,
        source=limit.source,
        result=found,
        coordinates=chosen.coordinates,
        guard_band=rule.guard(limits, known) if known else nan,
        false_accept_risk=rule.false_accept_risk(limits, known) if known else nan,
        false_reject_risk=rule.false_reject_risk(limits, known) if known else nan,
        probability=probability_within(limits, sure) if sure else nan,
        uncompensated=raw,
        marginal=bool(sure and rule.is_marginal(limits, sure)),
        measurand=limit.measurand,
    )


def _objection(limit: Limit, evidence: Evidence) -> str:
    """Return why a limit is for another measurand than that of the results, as a sentence."""
    named = (each.of for each in (*evidence.results, *evidence.means) if each.name == limit.of)
    found = next(named, None)
    if found is None or found.measurand is None:
        return ""
    message, _ = limit.objection_to(found)
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
