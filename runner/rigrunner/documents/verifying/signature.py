"""Checks who signed a document, when, and whether the key is trusted."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.proof.signature import check_signature, parse_signature

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rigrunner.documents.verifying.forms import Form
    from rigrunner.documents.verifying.verification import Verification

UNSIGNED = "unsigned: nothing shows who issued it"


def check_signature_of(
    verification: Verification, path: Path, forms: Sequence[Form], trusted: Sequence[Path]
) -> bool:
    """Check the signature file at `path`; return whether a trusted key signed every form.

    With trusted keys, a document that none of them signed is a difference; without, it is
    information.
    """
    if not path.is_file():
        (verification.differences if trusted else verification.information).append(UNSIGNED)
        return False
    try:
        signature = parse_signature(path.read_bytes(), path.name)
        key = check_signature(signature)
    except DataError as error:
        verification.differences.append(f"signature {path.name}: {error.message}")
        return False
    from rigrunner.proof.keys import (  # noqa: PLC0415  (needs the extra 'sign')
        fingerprint,
        public_pem,
        read_public_keys,
    )

    who = f"signed by {signature.signer} at {signature.signed_utc}, key {fingerprint(key)}"
    differences = []
    for form in forms:
        if form.name not in signature.files:
            differences.append(f"{form.name} is not signed")
        elif signature.files[form.name] not in form.digests:
            differences.append(f"{form.name} is not the file that was signed")
    if not verification.take(f"signature {path.name}", differences):
        return False
    trusted_keys = {public_pem(each) for file in trusted for each in read_public_keys(file)}
    if public_pem(key) in trusted_keys:
        verification.held.append(f"{who}, which is trusted")
        return True
    if trusted_keys:
        verification.differences.append(f"{who}, which is not among the trusted keys")
    else:
        verification.information.append(f"{who}; whether that key is theirs is not known (--trust)")
    return False
