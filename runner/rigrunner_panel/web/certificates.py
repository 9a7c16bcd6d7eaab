"""Certificates of a stored run: issued, amended, withdrawn, verified and signed."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from rigrunner.api.certificate import Authorisation, parse_certificate
from rigrunner.api.errors import DataError
from rigrunner.certificate.numbers import Numbers, prefix_of
from rigrunner.certificate.order import Order
from rigrunner.documents.certifying.amend import AmendRequest, amend
from rigrunner.documents.certifying.certify import Request, certify
from rigrunner.documents.certifying.sign import Signer, sign
from rigrunner.documents.certifying.withdraw import withdraw
from rigrunner.documents.verifying.certificate import Means, verify_certificate
from rigrunner.documents.verifying.forms import paths_of, signature_file_of
from rigrunner.documents.verifying.run import verify_run
from rigrunner.registry import load_registry
from rigrunner_panel.errors import PanelError, not_found
from rigrunner_panel.web.answers import (
    CertificateItem,
    Certificates,
    IssuedAnswer,
    SignedAnswer,
    VerificationAnswer,
    WithdrawnAnswer,
)

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rigrunner.api.certificate import Certificate
    from rigrunner.documents.certifying.office import Issued
    from rigrunner.documents.verifying.verification import Verification
    from rigrunner_panel.web.operation import ApiRequest
    from rigrunner_panel.web.panel import Panel
    from rigrunner_panel.web.requests import (
        AskAmendment,
        AskCertificate,
        AskSignature,
        AskWithdrawal,
    )

LONGEST = 20_000_000
"""The most bytes of a file that is read as a certificate."""


def certificates(panel: Panel, request: ApiRequest) -> Certificates:
    """Return the certificates in a run's folder, oldest first."""
    name = request.path["run"]
    folder = panel.history.folder(name)
    items = [_item(panel, name, path, each) for path, each in _certificates_in(folder)]
    key = panel.settings.signing_key is not None
    ordered = sorted(items, key=lambda item: (item.issued_utc, item.number))
    return Certificates(items=ordered, can_sign=key)


def issue(panel: Panel, request: ApiRequest) -> IssuedAnswer:
    """Issue a certificate for a stored run, under the laboratory's letterhead."""
    body: AskCertificate = request.body
    name = request.path["run"]
    certification = Request(
        letterhead=panel.settings.letterhead,
        order=Order(),
        authorisation=Authorisation(by=body.authorised_by.strip(), role=body.role.strip()),
        not_for_certification=body.not_for_certification,
        language=body.language,
        order_fields=body.order,
        further_copy=body.further_copy,
    )
    issued = certify(panel.history.folder(name), certification, load_registry(), panel.now())
    return _issued_answer(panel, name, issued)


def change(panel: Panel, request: ApiRequest) -> IssuedAnswer:
    """Issue a document that replaces a certificate; what is not given stays as it is."""
    body: AskAmendment = request.body
    name = request.path["run"]
    amendment = AmendRequest(
        letterhead=panel.settings.letterhead,
        reason=body.reason.strip(),
        authorisation=Authorisation(by=body.authorised_by.strip(), role=body.role.strip()),
        changes={key: text for key, text in body.order.items() if text.strip()},
    )
    issued = amend(_file(panel, request), amendment, load_registry(), panel.now())
    return _issued_answer(panel, name, issued)


def withdraw_certificate(panel: Panel, request: ApiRequest) -> WithdrawnAnswer:
    """Withdraw a certificate; its files do not change."""
    body: AskWithdrawal = request.body
    letterhead, path = panel.settings.letterhead, _file(panel, request)
    notice = withdraw(path, letterhead, by=body.by, reason=body.reason, now=panel.now())
    return WithdrawnAnswer(files=panel.links(request.path["run"], [notice]))


def verify(panel: Panel, request: ApiRequest) -> VerificationAnswer:
    """Verify a certificate, and compute its numbers again from the samples."""
    path = _file(panel, request)
    signed = signature_file_of(path).is_file()  # an unsigned certificate may be valid
    means = Means(
        run=panel.history.folder(request.path["run"]),
        runs=panel.settings.runs,
        registry=load_registry(),
        trusted=_trusted_keys(panel) if signed else (),
        letterhead=panel.settings.letterhead,
    )
    return _verification(verify_certificate(path, means))


def verify_stored(panel: Panel, request: ApiRequest) -> VerificationAnswer:
    """Verify a stored run, and compute its result again from the samples."""
    return _verification(verify_run(panel.history.folder(request.path["run"]), load_registry()))


def sign_certificate(panel: Panel, request: ApiRequest) -> SignedAnswer:
    """Sign a certificate with the key that the panel was started with."""
    body: AskSignature = request.body
    if panel.settings.signing_key is None:
        hint = "start the panel with --signing-key"
        raise PanelError(409, "wrong_state", "this panel has no key to sign with", hint)
    signer = Signer(
        key=panel.settings.signing_key,
        by=body.by.strip(),
        letterhead=panel.settings.letterhead,
        passphrase=body.passphrase,
    )
    signature = sign(_file(panel, request), signer, load_registry(), panel.now())
    return SignedAnswer(files=panel.links(request.path["run"], [signature]))


def _certificates_in(folder: Path) -> Iterator[tuple[Path, Certificate]]:
    """Yield the certificates of a folder with their files."""
    for path in folder.glob("*.json"):
        with suppress(DataError, OSError):
            if path.is_symlink() or path.stat().st_size > LONGEST:
                continue
            yield path, parse_certificate(path.read_bytes(), path.name)


def _item(panel: Panel, run: str, path: Path, certificate: Certificate) -> CertificateItem:
    numbers = Numbers(panel.settings.letterhead, prefix_of(certificate.number))
    signature = signature_file_of(path)
    files = [*paths_of(path), *([signature] if signature.is_file() else [])]
    return CertificateItem(
        number=certificate.number,
        issued_utc=certificate.issued_utc,
        by=certificate.authorisation.by,
        for_certification=not certificate.restrictions,
        amends="" if certificate.amends is None else certificate.amends.number,
        reason="" if certificate.amends is None else certificate.amends.reason,
        replaced_by=numbers.replaced_by(certificate.number),
        withdrawn=str(numbers.withdrawal_of(certificate.number) or ""),
        signed=signature.is_file(),
        files=panel.links(run, files),
    )


def _file(panel: Panel, request: ApiRequest) -> Path:
    """Return the JSON of the certificate of that number in a run's folder; raise PanelError."""
    number = request.path["number"]
    for path, certificate in _certificates_in(panel.history.folder(request.path["run"])):
        if certificate.number == number:
            return path
    raise not_found(f"the run has no certificate '{number[:80]}'")


def _issued_answer(panel: Panel, run: str, issued: Issued) -> IssuedAnswer:
    links = panel.links(run, issued.files)
    return IssuedAnswer(number=issued.certificate.number, files=links, notes=issued.notes)


def _trusted_keys(panel: Panel) -> tuple[Path, ...]:
    """Return the public half of the panel's key, if it is beside it."""
    key = panel.settings.signing_key
    public = None if key is None else key.with_name(f"{key.name}.pub")
    return (public,) if public is not None and public.is_file() else ()


def _verification(verification: Verification) -> VerificationAnswer:
    return VerificationAnswer.model_validate(verification, from_attributes=True)
