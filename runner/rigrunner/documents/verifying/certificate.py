"""Checks that a certificate is intact, and follows from its run."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from datetime import date
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError, RigrunnerError
from rigrunner.api.letterhead import Letterhead
from rigrunner.certificate.content import Issue, Source, make_certificate, restrictions_of
from rigrunner.certificate.order import ExternalEntry, OpinionEntry, Order
from rigrunner.certificate.results import conformity_of, named_of, results_of
from rigrunner.documents.verifying.decisions import check_decisions, decided_again
from rigrunner.documents.verifying.document import (
    Document,
    check_document,
    read_contents,
    read_forms,
)
from rigrunner.documents.verifying.forms import signature_file_of
from rigrunner.documents.verifying.revisions import CERTIFICATE, methods_used, other_revisions
from rigrunner.documents.verifying.run import check_run, versions
from rigrunner.documents.verifying.signature import check_signature_of
from rigrunner.documents.verifying.verification import Verification
from rigrunner.procedure import parse_procedure
from rigrunner.proof.compare import mismatches
from rigrunner.run.decision_records import acceptance_of
from rigrunner.run.locate import RUN_FILE
from rigrunner.run.provenance import is_simulated, software
from rigrunner.run.stored import analyse_stored
from rigrunner.runfile import read_truth, sealed_file_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from rigrunner.api.certificate import Certificate
    from rigrunner.api.results import Result
    from rigrunner.documents.verifying.run import CheckedRun
    from rigrunner.registry import Registry

_MARKS = (b"certificate/1", b"seal: sha256 ", b'"seal": "sha256 ')
# Bytes and manifest of the run have checks of their own, which say more of a difference.
_CHECKED_SEPARATELY = ("evidence/run/file_sha256", "evidence/run/manifest_sha256")


@dataclass(frozen=True, kw_only=True)
class Means:
    """What a certificate is verified with."""

    run: Path | None
    """The run; None: searched beside the certificate and among the runs."""
    runs: Path
    registry: Registry
    trusted: Sequence[Path] = ()
    """Files of public keys; with any, an unknown signer is a difference."""
    letterhead: Path | None = None
    """The folder of the laboratory, to make the pages again as issued."""


def verify_certificate(path: Path, means: Means) -> Verification:
    """Check every form of a document, its signature, its run, and each number against the run.

    Raises UsageError if the file does not exist, and DataError if it is not a certificate.
    """
    verification = Verification()
    forms = list(read_forms(verification, path))
    content = next((form.content for form in forms if form.path == path), b"")
    if not any(mark in content for mark in _MARKS):
        raise DataError(
            f"{path} is not a certificate: it has neither a seal nor a certificate's content",
            hint="'rigrunner certify' makes certificates; reports and results have no seal",
        )
    document = Document(path, forms, read_contents(verification, forms))
    signed = check_signature_of(verification, signature_file_of(path), forms, means.trusted)
    if document.contents:
        check_document(verification, document, means.registry, means.letterhead, signed=signed)
        _check_run(verification, document.certificate, path, means)
    return verification


def _check_run(
    verification: Verification, certificate: Certificate, path: Path, means: Means
) -> None:
    evidence = certificate.evidence.run
    places = (path.parent, path.parent / evidence.run_id, means.runs / evidence.run_id)
    run = means.run or next((place for place in places if (place / RUN_FILE).exists()), None)
    if run is None:
        verification.unchecked.append(
            f"the run {evidence.run_id} is neither beside the certificate nor in {means.runs}:"
            " no number was recomputed"
        )
        return
    sealed = sealed_file_of(run)
    if sealed is None:
        message = f"{run} is not sealed, and a certificate names a sealed run"
        verification.differences.append(message)
        return
    count_before = len(verification.differences)
    of_run = Verification()
    checked = check_run(of_run, run, means.registry)
    verification.held.extend(of_run.held)
    verification.differences.extend(of_run.differences)
    verification.unchecked.extend(of_run.unchecked)
    # The certificate's numbers have revisions of their own, which decide.
    verification.information.extend(
        f"the run's own result was not recomputed: {text}" for text in of_run.not_recomputed
    )
    verification.information.extend(of_run.information)
    with sealed.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    changed = []
    if digest != evidence.file_sha256:
        explanation = "its differences are listed above"
        if len(verification.differences) == count_before:
            explanation = (
                "nothing recorded in it differs from its manifest: the change is in the layout of"
                " the file, or manifest and content were changed together"
            )
        names = f"SHA-256 {digest}, and the certificate names {evidence.file_sha256}"
        changed.append(f"{names}; {explanation}")
    verification.take(f"bytes of {sealed.name}", changed)
    if checked is None:
        return
    stored = checked.stored
    if stored.header.run_id != evidence.run_id:
        verification.differences.append(
            f"run: the certificate names {evidence.run_id}, and {run} is {stored.header.run_id}"
        )
        return
    actual, stated = stored.manifest_sha256, evidence.manifest_sha256
    if actual or stated:
        differs = (
            f"the file's manifest has the SHA-256 {actual or '(none)'}, not {stated or '(none)'}"
        )
        what = "manifest named by the certificate"
        verification.take(what, [] if actual == stated else [differs])
    check_decisions(verification, certificate, stored, run)
    _check_numbers(verification, certificate, checked, digest, means.registry)
    now = software(means.registry)
    verification.information.extend(versions(certificate.evidence.issued_with, now, "was issued"))


def _check_numbers(
    verification: Verification,
    certificate: Certificate,
    checked: CheckedRun,
    digest: str,
    registry: Registry,
) -> None:
    """Make the certificate again from its run, by the recorded revisions only."""
    stored, run = checked.stored, checked.path
    decisions = decided_again(certificate)
    try:
        procedure = parse_procedure(
            stored.header.procedure_text, stored.header.procedure_id, stored=True
        ).model
    except RigrunnerError as error:
        verification.differences.append(f"procedure in the run: it cannot be read: {error}")
        return
    acceptance = acceptance_of(decisions[-1]) if decisions else None
    revisions, software_then = certificate.evidence.revisions, certificate.evidence.issued_with
    methods, content = (
        list(other_revisions(names, revisions, software_then, registry))
        for names in (methods_used(procedure, registry, acceptance), [CERTIFICATE])
    )
    verification.not_recomputed.extend([*methods, *content])
    if methods:
        return
    # Decided again, the run's own result has another verdict.
    run_result = None if decisions else checked.result

    def derived() -> Result:
        return run_result or analyse_stored(stored, registry, acceptance=acceptance)

    def differs() -> Iterator[object]:
        source = Source(
            stored=stored,
            result=derived(),
            file_sha256=digest,
            simulated=bool(read_truth(run)) or is_simulated(stored.header.provenance),
            decided_again=decisions,
        )
        regenerated = _made_again(certificate, source)
        recorded = certificate.model_dump(mode="json")
        for mismatch in mismatches(recorded, regenerated.model_dump(mode="json")):
            if mismatch.where not in _CHECKED_SEPARATELY:
                yield mismatch

    if content:
        what = "results and verdict recomputed from the run"
        verification.attempt(what, lambda: _results_differ(certificate, derived()))
    else:
        verification.attempt("certificate regenerated from the run", differs)


def _results_differ(certificate: Certificate, result: Result) -> Iterator[object]:
    """Yield differences of results and verdict, which all revisions share."""
    recomputed = (results_of(result), named_of(result), conformity_of(result.decision, ()))
    recorded, derived = (
        {
            "results": None if results is None else results.model_dump(mode="json"),
            "named": [result.model_dump(mode="json") for result in named],
            "verdict": None if conformity is None else conformity.verdict,
        }
        for results, named, conformity in (
            (certificate.results, certificate.named, certificate.conformity),
            recomputed,
        )
    )
    return mismatches(recorded, derived)


def _made_again(certificate: Certificate, source: Source) -> Certificate:
    requested = any(restriction.code == "requested" for restriction in certificate.restrictions)
    return make_certificate(
        source,
        _order_of(certificate),
        Letterhead(
            laboratory=certificate.laboratory,
            language=certificate.appearance.language,
            prefix="",
            statements=certificate.statements,
            files=certificate.appearance.files,
        ),
        Issue(
            number=certificate.number,
            issued_utc=certificate.issued_utc,
            authorisation=certificate.authorisation,
            restrictions=tuple(restrictions_of(source, requested=requested)),
            software=certificate.evidence.issued_with,
            amends=certificate.amends,
            further_copy=certificate.further_copy,
            layouts=certificate.appearance.layouts,
        ),
    )


def _order_of(certificate: Certificate) -> Order:
    """Return the entries of people on the certificate, which no run knows."""
    item, customer = certificate.item, certificate.customer
    deviations = (each.text for each in certificate.deviations if each.kind == "stated")
    try:
        received = date.fromisoformat(item.received)
    except ValueError as error:
        raise DataError(f"item.received: '{item.received}' is not a date") from error
    return Order(
        customer=customer.name,
        customer_contact=customer.contact,
        customer_reference=customer.reference,
        item=item.description,
        item_id=item.identification,
        item_condition=item.condition,
        received=received,
        sampling=item.sampling,
        conditions=certificate.conditions_stated,
        operator=certificate.performance.operator,
        deviations=tuple(deviations),
        opinions=tuple(OpinionEntry(text=each.text, by=each.by) for each in certificate.opinions),
        external=tuple(
            ExternalEntry(text=each.text, provider=each.provider) for each in certificate.external
        ),
    )
