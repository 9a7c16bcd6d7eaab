"""The digest of a procedure with all that it calls: what an approval is bound to."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

PROCEDURE = "procedure"
"""Stands for the name of the procedure's own file, which may be renamed."""


def texts_digest(text: str, called: Mapping[str, str]) -> str:
    """Return a SHA-256, hexadecimal, over a procedure's text and those that it calls, by path.

    It is the digest of a list as `sha256sum` prints it: a line for the procedure, then one for each
    called file, sorted by path; each line is the SHA-256 of a text in UTF-8, two spaces and a name.
    """
    names = [(PROCEDURE, text), *sorted(called.items())]
    return _sha256("".join(f"{_sha256(each)}  {name}\n" for name, each in names))


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
