"""Later decisions in the form of a certificate."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.certificate import DecisionRecord
from rigrunner.api.errors import DataError
from rigrunner.procedure import Acceptance
from rigrunner.procedure.kinds import STORED
from rigrunner.yamlfile.upgrade import upgraded_acceptance

if TYPE_CHECKING:
    from rigrunner.run.decisions import DecisionFile


def record_of(decision: DecisionFile) -> DecisionRecord:
    """Return a later decision in the form of a certificate."""
    summary = decision.summary
    return DecisionRecord(
        file=summary.file,
        sha256=decision.sha256,
        decided_utc=summary.decided_utc,
        by=summary.by,
        reason=summary.why,
        verdict=summary.verdict,
        rule=summary.rule,
        limit=summary.limit_text,
        verdict_before=summary.verdict_before,
        rule_before=summary.rule_before,
        limit_before=summary.limit_before,
        acceptance=decision.document["acceptance"],
    )


def acceptance_of(record: DecisionRecord) -> Acceptance:
    """Return limits and rule of a decision on a certificate; raise DataError."""
    try:
        content = upgraded_acceptance(record.acceptance)
        return Acceptance.model_validate(content, context={STORED: True})
    except ValueError as error:
        raise DataError(f"the limits and rule of {record.file} cannot be read") from error
