"""The decision in `result.json` and in the record of a later decision."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.analysis.document_values import estimate, number, quantity

if TYPE_CHECKING:
    from rigrunner.analysis.document_values import Json
    from rigrunner.api.results import Decision, LimitDecision

TORQUE = "N·m"


def decision(found: Decision) -> Json:
    """Return a decision as plain values: the deciding limit's, with rule and all parts."""
    return {
        **_limit_decision(found),
        "rule": found.rule,
        "parts": [_limit_decision(part) for part in found.parts],
    }


def _limit_decision(found: LimitDecision) -> Json:
    return {
        "of": found.of,
        "verdict": str(found.verdict),
        "reason": found.reason,
        "limit": found.limit_text,
        "lower_limit": quantity(found.lower_nm, TORQUE),
        "upper_limit": quantity(found.upper_nm, TORQUE),
        "limit_source": found.limit_source,
        "measurand": _measurand(found),
        "result": estimate(found.result),
        "guard_band": quantity(found.guard_band_nm, TORQUE),
        "stated_risk": {
            "false_accept": number(found.stated_risk),
            "false_reject": number(found.false_reject_risk),
        },
        "probability_of_conformity": number(found.probability_of_conformity),
        "marginal": found.marginal,
        "verdict_uncompensated": str(found.uncompensated),
    }


def _measurand(found: LimitDecision) -> Json | None:
    if found.measurand is None:
        return None
    return {
        "nature": str(found.measurand.nature),
        "condition": str(found.measurand.condition),
        "load": None if found.load_n is None else quantity(found.load_n, "N"),
        "text": str(found.measurand),
    }
