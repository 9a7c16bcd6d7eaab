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
    found: Verification, path: Path, forms: Sequence[Form], trusted: Sequence[Path]
) -> bool:
    """Check the signature file at `path`; return whether a trusted key signed every form.

    With trusted keys, a document that none of them signed is a difference; without, it is
    information.
    """
    if not path.is_file():
        (found.differences if trusted else found.information).append(UNSIGNED)
        return False
    try:
        signature = parse_signature(path.read_bytes(), path.name)
        key = check_signature(signature)
    except DataError as error:
        found.differences.append(f"signature {path.name}: {error.message}")
        return False
    from rigrunner.proof.keys import (  # noqa: PLC0415  (needs the extra 'sign')
        fingerprint,
        public_pem,
        read_public_keys,
    )

    who = f"signed by {signature.signer} at {signature.signed_utc}, key {fingerprint(key)}"
    other = []
    for form in forms:
        if form.name not in signature.files:
            other.append(f"{form.name} is not signed")
        elif signature.files[form.name] not in form.digests:
            other.append(f"{form.name} is not the file that was signed")
    if not found.take(f"signature {path.name}", other):
        return False
    known = {public_pem(each) for file in trusted for each in read_public_keys(file)}
    if public_pem(key) in known:
        found.held.append(f"{who}, which is trusted")
        return True
    if known:
        found.differences.append(f"{who}, which is not among the trusted keys")
    else:
        found.information.append(f"{who}; whether that key is theirs is not known (--trust)")
    return False
