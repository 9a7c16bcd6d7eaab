"""Checks that the decision on a certificate is in force, as recorded beside the run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.proof.compare import mismatches
from rigrunner.run.decision_records import record_of
from rigrunner.run.decisions import later_decisions

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.api.certificate import Certificate, DecisionRecord
    from rigrunner.documents.verifying.verification import Verification
    from rigrunner.runfile import StoredRun


def decided_again(certificate: Certificate) -> tuple[DecisionRecord, ...]:
    """Return the later decisions that a certificate states, oldest first."""
    return () if certificate.conformity is None else certificate.conformity.decided_again


def check_decisions(
    found: Verification, certificate: Certificate, stored: StoredRun, run: Path
) -> None:
    """Compare the decisions on a certificate with those recorded beside its run."""
    what = "decisions on record beside the run"
    records = decided_again(certificate)
    try:
        files = later_decisions(stored, run if run.is_dir() else run.parent)
    except DataError as error:
        found.take(what, [error])
        return
    there = {each.path.name: each for each in files}
    # Each follows the one before it: behind those of the certificate are what it lacks.
    others = files[len(records) :]
    missing = [each.file for each in records if each.file not in there]
    if missing:
        found.unchecked.append(
            f"{', '.join(missing)} is not beside the run: the decision was recomputed, but"
            " only the certificate states who decided it and why"
        )
    differs: list[object] = []
    for record in records:
        if record.file in there:
            wanted = record_of(there[record.file]).model_dump(mode="json")
            differs.extend(mismatches(record.model_dump(mode="json"), wanted, record.file))
    for other in others:
        name, summary = other.path.name, other.summary
        if summary.decided_utc <= certificate.issued_utc:
            differs.append(
                f"{name} of {summary.decided_utc} decides '{summary.verdict}',"
                f" and the certificate of {certificate.issued_utc} does not state it"
            )
        else:
            found.information.append(
                f"the run was decided again after this certificate was issued:"
                f" '{summary.verdict}' by {summary.by} in {name}"
            )
    if (records and not missing) or differs:
        found.take(what, differs)
