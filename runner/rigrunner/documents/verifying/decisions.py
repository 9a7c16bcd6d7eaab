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
    verification: Verification, certificate: Certificate, stored: StoredRun, run: Path
) -> None:
    """Compare the decisions on a certificate with those recorded beside its run."""
    what = "decisions on record beside the run"
    records = decided_again(certificate)
    try:
        files = later_decisions(stored, run if run.is_dir() else run.parent)
    except DataError as error:
        verification.take(what, [error])
        return
    by_name = {file.path.name: file for file in files}
    # Each follows the one before it: behind those of the certificate are what it lacks.
    further = files[len(records) :]
    missing = [record.file for record in records if record.file not in by_name]
    if missing:
        verification.unchecked.append(
            f"{', '.join(missing)} is not beside the run: the decision was recomputed, but"
            " only the certificate states who decided it and why"
        )
    differences: list[object] = []
    for record in records:
        if record.file in by_name:
            recorded = record_of(by_name[record.file]).model_dump(mode="json")
            differences.extend(mismatches(record.model_dump(mode="json"), recorded, record.file))
    for file in further:
        name, summary = file.path.name, file.summary
        if summary.decided_utc <= certificate.issued_utc:
            differences.append(
                f"{name} of {summary.decided_utc} decides '{summary.verdict}',"
                f" and the certificate of {certificate.issued_utc} does not state it"
            )
        else:
            verification.information.append(
                f"the run was decided again after this certificate was issued:"
                f" '{summary.verdict}' by {summary.by} in {name}"
            )
    if (records and not missing) or differences:
        verification.take(what, differences)
