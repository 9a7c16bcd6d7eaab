"""The issued certificate that is to be replaced or withdrawn."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.certificate import parse_certificate
from rigrunner.api.errors import DataError, UsageError
from rigrunner.certificate.numbers import Numbers, prefix_of

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.api.certificate import Certificate


@dataclass(frozen=True)
class Original:
    """A certificate as issued, which no other replaces."""

    certificate: Certificate
    file: Path
    """Its JSON."""
    sha256: str
    numbers: Numbers
    """The sequence of its number."""


def read_original(path: Path, letterhead: Path) -> Original:
    """Read the certificate at a path (its JSON, or a form beside it).

    Raises UsageError if it does not exist, was replaced, or was not issued under the letterhead in
    that folder, and DataError if it is not a certificate or not as issued.
    """
    file = path.with_suffix(".json")
    try:
        content = file.read_bytes()
    except FileNotFoundError as error:
        raise UsageError(
            f"there is no {file}", hint="name a certificate with its JSON beside it"
        ) from error
    except OSError as error:
        raise DataError(f"{file} cannot be read: {error.strerror or error}") from error
    certificate = parse_certificate(content, str(file))
    number, sha256 = certificate.number, hashlib.sha256(content).hexdigest()
    numbers = Numbers(letterhead, prefix_of(number))
    issued = numbers.digests_of(number)
    if issued and sha256 not in issued:
        raise DataError(
            f"{number} has changed since it was issued: its SHA-256 is {sha256[:12]}…",
            hint=f"the laboratory's {letterhead} has another on record",
        )
    if not issued:
        raise UsageError(
            f"{number} was not issued under the letterhead in {letterhead}",
            hint="name the folder that holds its number with --letterhead",
        )
    if replaced := numbers.replaced_by(number):
        raise UsageError(f"{number} was already replaced by {replaced}", hint="choose that one")
    return Original(certificate, file, sha256, numbers)
