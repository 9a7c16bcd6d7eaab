"""The decision in `result.json` and in the record of a later decision."""

from __future__ import annotations

from math import isinf
from typing import TYPE_CHECKING, Any

from rigrunner.signal.as_json.values import coordinates_of, estimate, number, quantity

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.results import JudgedValue, MeasuredLimits, Result
    from rigrunner.api.verdict import Decision, LimitDecision
    from rigrunner.signal.as_json.values import Json

MOST_VALUES = 1000
"""The most judged values that are listed, those out of limits first: a scan may have thousands."""


def verdict(result: Result) -> Json | None:
    """Return the verdict on a run with its reason; None where nothing is decided."""
    if result.verdict is None:
        return None
    return {"verdict": str(result.verdict), "reason": result.verdict_reason}


def verdict_in(document: Mapping[str, Any] | None) -> str:
    """Return the verdict on a run as its result document has it; '' for none.

    In a document of a program that had no limits on measured values it is that of the decision.
    """
    content = document or {}
    decision = content["verdict"] if "verdict" in content else content.get("decision")
    return str((decision or {}).get("verdict", ""))


def limits(measured: MeasuredLimits) -> Json | None:
    """Return the limits on measured values, each with its decision; None where there is none."""
    if not measured.values:
        return None
    values = sorted(measured.values, key=lambda value: value.passes)[:MOST_VALUES]
    return {
        "verdict": str(measured.verdict),
        "reason": measured.reason,
        "judged": len(measured.values),
        "missed": len(measured.missed),
        "values": [_judged_value(value) for value in values],
    }


def _judged_value(judged: JudgedValue) -> Json:
    row, decision = judged.row, judged.decision
    limits, unit = decision.limits, row.units.get(decision.of, "")
    bounds = {"lower_limit": limits.lower, "upper_limit": limits.upper}
    return {
        "table": row.name,
        "row": judged.number,
        "utc": row.utc,
        "recording": row.recording or None,
        "setpoints": {
            name: quantity(value, row.units.get(name, "")) for name, value in row.setpoints.items()
        },
        **({"coordinates": dict(row.coordinates)} if row.coordinates else {}),
        "of": decision.of,
        "result": quantity(judged.value, unit),
        **{name: None if isinf(bound) else quantity(bound, unit) for name, bound in bounds.items()},
        "shown": judged.shown,
        "allowed": limits.in_words,
        "verdict": str(decision.verdict),
        "marginal": decision.marginal,
        "text": decision.reason,
    }


def decision(decision: Decision) -> Json:
    """Return a decision as plain values: the deciding limit's, with rule and all parts."""
    return {
        **_limit_decision(decision.deciding),
        "rule": decision.rule,
        "parts": [_limit_decision(part) for part in decision.parts],
    }


def _limit_decision(decision: LimitDecision) -> Json:
    limits, unit, uncompensated = decision.limits, decision.limits.unit, decision.uncompensated
    return {
        "of": decision.of,
        **({"named": decision.named} if decision.named else {}),
        "verdict": str(decision.verdict),
        "reason": decision.reason,
        "limit": str(limits),
        "lower_limit": quantity(limits.lower, unit),
        "upper_limit": quantity(limits.upper, unit),
        "limit_source": decision.source,
        **({"coordinates": coordinates_of(decision.coordinates)} if decision.coordinates else {}),
        "measurand": None if decision.measurand is None else dict(decision.measurand.document()),
        "result": estimate(decision.result),
        "guard_band": quantity(decision.guard_band, unit),
        "stated_risk": {
            "false_accept": number(decision.false_accept_risk),
            "false_reject": number(decision.false_reject_risk),
        },
        "probability_of_conformity": number(decision.probability),
        "marginal": decision.marginal,
        "verdict_uncompensated": None if uncompensated is None else str(uncompensated),
    }
