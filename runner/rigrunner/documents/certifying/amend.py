"""Issue the document that replaces an issued certificate; the original stays as it is."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import date
from typing import TYPE_CHECKING

from rigrunner.analysis.revisions import FIRST
from rigrunner.api.errors import DataError, UsageError
from rigrunner.api.progress import unseen
from rigrunner.certificate.amending import amended, amendment_of
from rigrunner.certificate.content import Issue
from rigrunner.certificate.letterhead import read_letterhead
from rigrunner.certificate.results import conformity_of
from rigrunner.clock import utc_text
from rigrunner.documents.certifying.certify import read_source, refuse_late_receipt
from rigrunner.documents.certifying.office import Issued, Office
from rigrunner.documents.certifying.original import read_original
from rigrunner.run.provenance import layouts, software

if TYPE_CHECKING:
    from collections.abc import Mapping
    from datetime import datetime
    from pathlib import Path

    from rigrunner.api.certificate import Authorisation, Certificate, Conformity
    from rigrunner.api.progress import Progress
    from rigrunner.registry import Registry


@dataclass(frozen=True, kw_only=True)
class AmendRequest:
    """The request to amend."""

    letterhead: Path
    """The laboratory's folder."""
    reason: str
    authorisation: Authorisation
    """Who amends, and so authorises the new document."""
    language: str = ""
    """The language; by default that of the original."""
    out: Path | None = None
    """The folder to write into; None for that of the original."""
    changes: Mapping[str, str] = field(default_factory=dict)
    """The changes, by field of the order."""
    run: Path | None = None
    """The run, if the document is to state the decision that is now in force on it."""


def amend(
    path: Path,
    request: AmendRequest,
    registry: Registry,
    now: datetime,
    *,
    progress: Progress = unseen,
) -> Issued:
    """Issue a document that replaces the one at a path (its JSON, or a form beside it).

    If that one was withdrawn, the new document says so.
    Raises UsageError if something is missing, the document was replaced before or nothing changes,
    and DataError if the original is not a certificate or not as issued.
    """
    if not request.reason.strip():
        raise UsageError("an amendment needs its --reason", field="reason")
    replaced = read_original(path, request.letterhead)
    original = replaced.certificate
    if "received" in request.changes:
        text = request.changes["received"]
        try:
            received = date.fromisoformat(text)
        except ValueError as error:
            message = f"--received: '{text}' is not a date; write it as 2026-01-31"
            raise UsageError(message, field="received") from error
        refuse_late_receipt(received, original.performance.started_utc)
    letterhead = read_letterhead(
        request.letterhead, request.language or original.appearance.language
    )
    run = request.run
    conformity = None if run is None else _conformity_in_force(original, run, registry)
    withdrawal = replaced.numbers.withdrawal_of(original.number)
    amendment = amendment_of(
        original, replaced.sha256, request.reason, request.authorisation.by, withdrawal
    )

    def replacement(number: str) -> Certificate:
        issue = Issue(
            number=number,
            issued_utc=utc_text(now),
            authorisation=request.authorisation,
            restrictions=original.restrictions,
            software=software(registry),
            layouts=layouts(registry),
            amends=amendment,
        )
        return amended(original, request.changes, letterhead, issue, conformity)

    office = Office(request.letterhead, letterhead, registry, now, progress)
    return office.issue(
        replacement, request.out or replaced.file.parent, is_specimen=bool(original.restrictions)
    )


def _conformity_in_force(original: Certificate, run: Path, registry: Registry) -> Conformity | None:
    """Return the statement of conformity of the decision in force; raise DataError."""
    source = read_source(run, registry)
    evidence, header = original.evidence, source.stored.header
    run_id, number = evidence.run.run_id, original.number
    if (header.run_id, source.stored.digest) != (run_id, evidence.run.digest_sha256):
        raise DataError(f"{header.run_id} is not the run of {number}: {run_id} is")
    differing = [
        f"{method} has revision {now}, {number} is by revision {then}"
        for method, now in source.result.revisions.items()
        if now != (then := evidence.revisions.get(method, FIRST))
    ]
    if differing:
        raise DataError(
            f"the decision cannot be taken over from {header.run_id}: {'; '.join(differing)}",
            hint="its numbers and its verdict would be by different revisions",
        )
    return conformity_of(source.result.decision, source.decided_again)
