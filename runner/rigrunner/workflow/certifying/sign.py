"""A laboratory signs its certificates: one signature over every form of a document."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError, UsageError
from rigrunner.clock import utc_text
from rigrunner.proof.places import place_in
from rigrunner.proof.seal import FORMS, check_seal
from rigrunner.proof.signature import sign_files, signature_json

if TYPE_CHECKING:
    from datetime import datetime
    from pathlib import Path

SIGNATURE_SUFFIX = ".sig.json"


def sign(certificate: Path, key: Path, signer: str, now: datetime, passphrase: str = "") -> Path:
    """Sign all forms of a certificate that lie beside the named one; return the signature's file.

    Raises UsageError for a key that cannot be used, or where the document is signed already, and
    DataError for a document whose seal does not hold: what was changed must not be signed.
    """
    from rigrunner.proof.keys import read_private_key  # noqa: PLC0415  (needs the extra 'sign')

    files = {path.name: _whole(path) for path in forms_of(certificate)}
    target = signature_file_of(certificate)
    private = read_private_key(key, passphrase)
    text = signature_json(sign_files(files, private, signer, utc_text(now)))
    try:
        with target.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise UsageError(
            f"{target} exists: the document is signed", hint="signatures are never overwritten"
        ) from error
    except OSError as error:
        raise UsageError(f"{target} cannot be written: {error.strerror}") from error
    return target


def forms_of(certificate: Path) -> list[Path]:
    """Return the files that are one document: JSON, HTML and PDF beside each other.

    Raises UsageError where the named one is not there, or is none of them.
    """
    if certificate.suffix not in FORMS or certificate.name.endswith(SIGNATURE_SUFFIX):
        raise UsageError(
            f"{certificate} is no certificate", hint=f"it is a file {', '.join(FORMS)}"
        )
    if not certificate.is_file():
        raise UsageError(f"there is no certificate {certificate}")
    return [path for suffix in FORMS if (path := certificate.with_suffix(suffix)).is_file()]


def signature_file_of(certificate: Path) -> Path:
    """Return where the signature of a certificate is."""
    return certificate.with_suffix(SIGNATURE_SUFFIX)


def _whole(path: Path) -> bytes:
    content = path.read_bytes()
    try:
        broken = check_seal(content, path.suffix)
    except DataError as error:
        raise DataError(f"{path} is not signed: {error}") from error
    if broken:
        where = place_in(content, path.suffix, broken[0].start, broken[0].end)
        raise DataError(f"{path} is not signed: it was changed after it was issued, at {where}")
    return content
