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
    found = document or {}
    decided = found["verdict"] if "verdict" in found else found.get("decision")
    return str((decided or {}).get("verdict", ""))


def limits(found: MeasuredLimits) -> Json | None:
    """Return the limits on measured values, each with its decision; None where there is none."""
    if not found.values:
        return None
    listed = sorted(found.values, key=lambda each: each.passes)[:MOST_VALUES]
    return {
        "verdict": str(found.verdict),
        "reason": found.reason,
        "judged": len(found.values),
        "missed": len(found.missed),
        "values": [_judged_value(each) for each in listed],
    }


def _judged_value(found: JudgedValue) -> Json:
    row, decided = found.row, found.decision
    limits, unit = decided.limits, row.units.get(decided.of, "")
    ends = {"lower_limit": limits.lower, "upper_limit": limits.upper}
    return {
        "table": row.name,
        "row": found.number,
        "utc": row.utc,
        "recording": row.recording or None,
        "setpoints": {
            name: quantity(each, row.units.get(name, "")) for name, each in row.setpoints.items()
        },
        **({"coordinates": dict(row.coordinates)} if row.coordinates else {}),
        "of": decided.of,
        "result": quantity(found.value, unit),
        **{name: None if isinf(end) else quantity(end, unit) for name, end in ends.items()},
        "shown": found.shown,
        "allowed": limits.in_words,
        "verdict": str(decided.verdict),
        "marginal": decided.marginal,
        "text": decided.reason,
    }


def decision(found: Decision) -> Json:
    """Return a decision as plain values: the deciding limit's, with rule and all parts."""
    return {
        **_limit_decision(found.deciding),
        "rule": found.rule,
        "parts": [_limit_decision(part) for part in found.parts],
    }


def _limit_decision(found: LimitDecision) -> Json:
    limits, unit = found.limits, found.limits.unit
    return {
        "of": found.of,
        **({"named": found.named} if found.named else {}),
        "verdict": str(found.verdict),
        "reason": found.reason,
        "limit": str(limits),
        "lower_limit": quantity(limits.lower, unit),
        "upper_limit": quantity(limits.upper, unit),
        "limit_source": found.source,
        **({"coordinates": coordinates_of(found.coordinates)} if found.coordinates else {}),
        "measurand": None if found.measurand is None else dict(found.measurand.document()),
        "result": estimate(found.result),
        "guard_band": quantity(found.guard_band, unit),
        "stated_risk": {
            "false_accept": number(found.false_accept_risk),
            "false_reject": number(found.false_reject_risk),
        },
        "probability_of_conformity": number(found.probability),
        "marginal": found.marginal,
        "verdict_uncompensated": None if found.uncompensated is None else str(found.uncompensated),
    }
