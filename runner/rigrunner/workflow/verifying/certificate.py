"""Whether a certificate is whole, and follows from the run that it names."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from datetime import date
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.api.letterhead import Letterhead
from rigrunner.certificate.content import Issue, Source, make_certificate, restrictions_of
from rigrunner.certificate.order import ExternalEntry, OpinionEntry, Order
from rigrunner.proof.compare import mismatches
from rigrunner.proof.contents import content_in
from rigrunner.proof.places import place_in
from rigrunner.proof.seal import check_seal
from rigrunner.runfile import read_truth, sealed_file_of
from rigrunner.workflow.certifying.sign import forms_of, signature_file_of
from rigrunner.workflow.provenance import is_simulated, software
from rigrunner.workflow.verifying.decisions import check_decisions, decided_again, decided_result
from rigrunner.workflow.verifying.number import check_number
from rigrunner.workflow.verifying.pages import check_pages
from rigrunner.workflow.verifying.run import check_run, versions
from rigrunner.workflow.verifying.signature import check_signature_of
from rigrunner.workflow.verifying.verification import Verification

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from rigrunner.api.certificate import Certificate, RunEvidence
    from rigrunner.registry import Registry
    from rigrunner.runfile import StoredRun

RUN_FILE = "run.h5"
_MARKS = (b"certificate/1", b"seal: sha256 ", b'"seal": "sha256 ')
_COMPARED_APART = ("evidence/run/file_sha256", "evidence/run/manifest_sha256")


@dataclass(frozen=True, kw_only=True)
class Means:
    """With what a certificate is verified, besides itself."""

    run: Path | None
    """The run; None: it is looked for beside the certificate and among the runs."""
    runs: Path
    registry: Registry
    trusted: Sequence[Path] = ()
    """Files of public keys; with any, an unknown signer is a difference."""
    letterhead: Path | None = None
    """The laboratory's folder, to make the pages again as they were issued."""


def verify_certificate(path: Path, means: Means) -> Verification:
    """Check every form of a document, its signature, its run, and each number against the run.

    Raises UsageError where there is no such file, and DataError where it is no certificate.
    """
    found = Verification()
    forms = forms_of(path)
    _refuse_others(path)
    contents = {each.name: _checked_form(found, each) for each in forms}
    known = {name: content for name, content in contents.items() if content is not None}
    check_signature_of(found, signature_file_of(path), forms, means.trusted)
    if known:
        first = path.name if path.name in known else next(iter(known))
        _check_same_content(found, first, known)
        for each in forms:
            if each.suffix != ".json" and each.name in known:
                check_pages(found, each, known[each.name], means.registry, means.letterhead)
        if means.letterhead is not None:
            check_number(found, forms, known[first].number, means.letterhead)
        _check_run(found, known[first], path, means)
    return found


def _refuse_others(path: Path) -> None:
    """Raise DataError for a file that was never a certificate, whatever was changed in it."""
    content = path.read_bytes()
    if not any(mark in content for mark in _MARKS):
        raise DataError(
            f"{path} is no certificate: it has neither a seal nor a certificate's content",
            hint="'rigrunner certify' makes certificates; reports and results have no seal",
        )


def _checked_form(found: Verification, path: Path) -> Certificate | None:
    """Check the seal of one file, and return its content where that can be read."""
    try:
        content = path.read_bytes()
    except OSError as error:
        found.differences.append(f"{path.name}: it cannot be read: {error.strerror}")
        return None
    found.attempt(f"seal of {path.name}", lambda: _broken_places(content, path.suffix))
    try:
        return content_in(content, path.suffix, path.name)
    except DataError as error:
        why = error.message.removeprefix(f"{path.name} ")
        found.differences.append(f"content of {path.name}: it {why}")
        return None


def _broken_places(content: bytes, suffix: str) -> Iterator[str]:
    for part in check_seal(content, suffix):
        yield f"changed at {place_in(content, suffix, part.start, part.end)}"


def _check_same_content(found: Verification, first: str, known: dict[str, Certificate]) -> None:
    wanted = known[first].model_dump(mode="json")
    for name, other in known.items():
        if name != first:
            named = list(mismatches(wanted, other.model_dump(mode="json")))
            differs: list[object] = [*named]
            if not named and other != known[first]:
                differs.append("its content differs by less than is printed")
            found.take(f"content of {name} is that of {first}", differs)


def _check_run(found: Verification, certificate: Certificate, path: Path, means: Means) -> None:
    evidence = certificate.evidence.run
    run = means.run or _run_beside(path, evidence.run_id, means.runs)
    if run is None:
        found.unchecked.append(
            f"the run {evidence.run_id} is neither beside the certificate nor in {means.runs}:"
            " no number was derived again"
        )
        return
    sealed = sealed_file_of(run)
    if sealed is None:
        found.differences.append(f"{run} is not sealed, and a certificate names a sealed run")
        return
    before = len(found.differences)
    checked = check_run(found, run, means.registry)
    digest = _sha256_of(sealed)
    sound = len(found.differences) == before
    found.take(f"bytes of {sealed.name}", _bytes_differ(digest, evidence, sound=sound))
    if checked is None:
        return
    stored = checked.stored
    if stored.header.run_id != evidence.run_id:
        found.differences.append(
            f"run: the certificate names {evidence.run_id}, and {run} is {stored.header.run_id}"
        )
        return
    if stored.manifest_sha256 or evidence.manifest_sha256:
        found.take("manifest named by the certificate", _manifest_differs(stored, evidence))
    check_decisions(found, certificate, stored, run)
    result = checked.result
    if result is not None:

        def differs() -> Iterator[object]:
            source = Source(
                stored=stored,
                result=decided_result(certificate, run, result, means.registry),
                file_sha256=digest,
                simulated=bool(read_truth(run)) or is_simulated(stored.header.provenance),
                decided_again=decided_again(certificate),
            )
            return _derived_differs(certificate, source)

        found.attempt("certificate made again from the run", differs)
    now = software(means.registry)
    found.information.extend(versions(certificate.evidence.issued_with, now, "was issued"))


def _run_beside(path: Path, run_id: str, runs: Path) -> Path | None:
    places = (path.parent, path.parent / run_id, runs / run_id)
    return next((each for each in places if (each / RUN_FILE).exists()), None)


def _sha256_of(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _bytes_differ(digest: str, evidence: RunEvidence, *, sound: bool) -> Iterator[str]:
    if digest != evidence.file_sha256:
        where = (
            "nothing recorded in it differs from its manifest: the change is in the layout of"
            " the file, or manifest and content were changed together"
            if sound
            else "what differs in it is told above"
        )
        yield f"SHA-256 {digest}, and the certificate names {evidence.file_sha256}; {where}"


def _manifest_differs(stored: StoredRun, evidence: RunEvidence) -> Iterator[str]:
    if stored.manifest_sha256 != evidence.manifest_sha256:
        yield (
            f"the file's manifest has the SHA-256 {stored.manifest_sha256 or '(none)'},"
            f" not {evidence.manifest_sha256 or '(none)'}"
        )


def _derived_differs(certificate: Certificate, source: Source) -> Iterator[object]:
    """Yield where the certificate is not what its run and its own entries make of it again."""
    derived = _made_again(certificate, source)
    recorded, made = certificate.model_dump(mode="json"), derived.model_dump(mode="json")
    for each in mismatches(recorded, made):
        if each.where not in _COMPARED_APART:
            yield each


def _made_again(certificate: Certificate, source: Source) -> Certificate:
    requested = any(each.code == "requested" for each in certificate.restrictions)
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
        ),
    )


def _order_of(certificate: Certificate) -> Order:
    """Return what people told, as the certificate has it: no run knows that."""
    item, customer = certificate.item, certificate.customer
    stated = (each.text for each in certificate.deviations if each.kind == "stated")
    return Order(
        customer=customer.name,
        customer_contact=customer.contact,
        customer_reference=customer.reference,
        item=item.description,
        item_id=item.identification,
        item_condition=item.condition,
        received=_date(item.received),
        sampling=item.sampling,
        conditions=certificate.conditions_stated,
        operator=certificate.performance.operator,
        deviations=tuple(stated),
        opinions=tuple(OpinionEntry(text=each.text, by=each.by) for each in certificate.opinions),
        external=tuple(
            ExternalEntry(text=each.text, provider=each.provider) for each in certificate.external
        ),
    )


def _date(text: str) -> date | None:
    try:
        return date.fromisoformat(text)
    except ValueError as error:
        raise DataError(f"item.received: '{text}' is no date") from error
