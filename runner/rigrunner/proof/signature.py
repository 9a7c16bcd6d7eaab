"""Signatures with the Ed25519 key of a laboratory (RFC 8032), in a separate file.

The signed text is JSON (keys sorted, no spaces) of all members but `signature`: the digests of the
files of the certificate, the name of the signer, the time and the public key.
"""

from __future__ import annotations

import base64
import hashlib
import json
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import DataError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from cryptography.hazmat.primitives.asymmetric.ed25519 import (
        Ed25519PrivateKey,
        Ed25519PublicKey,
    )

FORMAT = "rigrunner: signature/1"
_LONGEST = 1_000_000


@dataclass(frozen=True, kw_only=True)
class Signature:
    """Who signed which files, when; `signature` is base64 over the rest."""

    format: str
    signer: str
    signed_utc: str
    """By the clock of the signer."""
    public_key: str
    """PEM (SubjectPublicKeyInfo)."""
    files: Mapping[str, str]
    """SHA-256 by file name."""
    signature: str = ""


def sign_files(
    files: Mapping[str, bytes], key: Ed25519PrivateKey, signer: str, signed_utc: str
) -> Signature:
    """Return the signature over the contents of files."""
    from rigrunner.proof.keys import public_pem  # noqa: PLC0415  (needs the extra 'sign')

    digests = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
    unsigned = Signature(
        format=FORMAT,
        signer=signer,
        signed_utc=signed_utc,
        public_key=public_pem(key.public_key()),
        files=digests,
    )
    signature = base64.b64encode(key.sign(_signed_text(unsigned))).decode()
    return replace(unsigned, signature=signature)


def signature_json(signature: Signature) -> str:
    """Return the content of a signature file."""
    return json.dumps(asdict(signature), indent=1, ensure_ascii=False) + "\n"


def parse_signature(content: bytes, name: str) -> Signature:
    """Return the signature in a file; raise DataError if it is none."""
    try:
        # A file that is too long is refused as one without members.
        document: dict[str, Any] = json.loads(content) if len(content) <= _LONGEST else {}
        signature = Signature(**document)
    except (TypeError, ValueError, RecursionError) as error:
        raise DataError(f"{name} is not a signature file of this program") from error
    texts = (signature.signer, signature.signed_utc, signature.public_key, signature.signature)
    if signature.format != FORMAT or not all(isinstance(text, str) for text in texts):
        raise DataError(f"{name} is not of the format '{FORMAT}'")
    if not isinstance(signature.files, dict):
        raise DataError(f"{name}: 'files' must hold a digest by file name")
    return signature


def check_signature(signature: Signature) -> Ed25519PublicKey:
    """Return the key of the signature; raise DataError if it does not match."""
    from cryptography.exceptions import InvalidSignature  # noqa: PLC0415  (of the extra 'sign')

    from rigrunner.proof.keys import public_key_from  # noqa: PLC0415  (needs the extra 'sign')

    key = public_key_from(signature.public_key.encode(), "the signature's public key")
    try:
        key.verify(base64.b64decode(signature.signature, validate=True), _signed_text(signature))
    except (InvalidSignature, ValueError) as error:
        raise DataError(
            "the signature is not valid: the signed content was changed, or another key signed it"
        ) from error
    return key


def _signed_text(signature: Signature) -> bytes:
    members = asdict(signature)
    del members["signature"]
    return json.dumps(members, sort_keys=True, separators=(",", ":")).encode()
