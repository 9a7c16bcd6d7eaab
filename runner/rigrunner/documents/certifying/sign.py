"""Sign certificates: one signature over the bytes of every form of a document."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError, UsageError
from rigrunner.certificate.numbers import Numbers, prefix_of
from rigrunner.clock import utc_text
from rigrunner.documents.verifying.document import (
    Document,
    check_document,
    read_contents,
    read_forms,
)
from rigrunner.documents.verifying.forms import signature_file_of
from rigrunner.documents.verifying.verification import Verification
from rigrunner.proof.signature import sign_files, signature_json

if TYPE_CHECKING:
    from datetime import datetime
    from pathlib import Path

    from rigrunner.registry import Registry


@dataclass(frozen=True, kw_only=True)
class Signer:
    """The signer, with key and laboratory."""

    key: Path
    by: str
    letterhead: Path
    """The laboratory's folder: its record of numbers, and the templates of its pages."""
    passphrase: str = ""


def sign(certificate: Path, signer: Signer, registry: Registry, now: datetime) -> Path:
    """Sign all forms of a certificate beside the given one; return the signature's file.

    Every page is made again from the content and compared, and every form is compared with the
    laboratory's record of numbers. So only an unchanged document is signed. Raises UsageError for a
    key that cannot be used, or if the document is signed already, and DataError with the
    differences.
    """
    from rigrunner.proof.keys import read_private_key  # noqa: PLC0415  (needs the extra 'sign')

    verification = Verification()
    forms = list(read_forms(verification, certificate))
    private = read_private_key(signer.key, signer.passphrase)
    target = signature_file_of(certificate)
    if target.exists():
        raise _already_signed(target)
    document = Document(certificate, forms, read_contents(verification, forms))
    if not verification.differences:
        if not Numbers(signer.letterhead, prefix_of(document.certificate.number)).kept:
            raise DataError(
                f"{certificate} is not signed: {signer.letterhead} has no record of numbers, so it"
                " is not known whether it was issued",
                hint="name the laboratory's folder with --letterhead",
            )
        check_document(verification, document, registry, signer.letterhead, signed=False)
    problems = [
        *(*verification.differences, *verification.withdrawn),
        *(*verification.replaced, *verification.unproven),
    ]
    if problems:
        more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
        raise DataError(
            f"{certificate} is not signed: {problems[0]}{more}",
            hint="'rigrunner verify' with the same --letterhead lists all",
        )
    files = {form.name: form.content for form in forms}
    text = signature_json(sign_files(files, private, signer.by, utc_text(now)))
    try:
        with target.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise _already_signed(target) from error
    except OSError as error:
        raise UsageError(f"{target} cannot be written: {error.strerror}") from error
    return target


def _already_signed(target: Path) -> UsageError:
    return UsageError(
        f"{target} exists: the document is signed", hint="signatures are never overwritten"
    )
