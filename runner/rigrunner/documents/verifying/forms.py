"""The files of one document: JSON, HTML and PDF in one folder, and their signature."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError
from rigrunner.proof.seal import FORMS, issued_part, unsealed

if TYPE_CHECKING:
    from pathlib import Path

SIGNATURE_SUFFIX = ".sig.json"


@dataclass(frozen=True, eq=False)
class Form:
    """One file of a document with its bytes."""

    path: Path
    content: bytes

    @property
    def name(self) -> str:
        """The file's name."""
        return self.path.name

    @property
    def suffix(self) -> str:
        """Suffix of the file name, with the dot."""
        return self.path.suffix

    @cached_property
    def issued(self) -> bytes:
        """The bytes as issued: of a PDF without later additions."""
        return issued_part(self.content, self.suffix)

    @property
    def page(self) -> bytes:
        """The issued bytes without the seal."""
        return unsealed(self.issued, self.suffix)

    @property
    def digests(self) -> frozenset[str]:
        """SHA-256 of the file, and of the issued bytes."""
        contents = (self.content, self.issued)
        return frozenset(hashlib.sha256(content).hexdigest() for content in contents)


def paths_of(certificate: Path) -> list[Path]:
    """Return the files of the document with the named one.

    Raises UsageError if the named one does not exist, or is no document.
    """
    if certificate.suffix not in FORMS or certificate.name.endswith(SIGNATURE_SUFFIX):
        raise UsageError(
            f"{certificate} is not a certificate", hint=f"it is a file {', '.join(FORMS)}"
        )
    if not certificate.is_file():
        raise UsageError(f"there is no certificate {certificate}")
    return [path for suffix in FORMS if (path := certificate.with_suffix(suffix)).is_file()]


def signature_file_of(certificate: Path) -> Path:
    """Return the path of the signature of a certificate."""
    return certificate.with_suffix(SIGNATURE_SUFFIX)
