"""The seal of a document: SHA-256 of its bytes in its last line, with digests of its blocks.

HTML has it as a comment, PDF as a comment after `%%EOF`, JSON as the last member of its object. The
seal shows whether a document is unchanged, and where it is not. It does not show the author: for
that, documents are signed (`rigrunner.proof.signature`).
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from itertools import islice

from rigrunner.api.errors import DataError

MOST_BLOCKS = 40
"""The end mark of a PDF must be near the end of the file, which limits the line."""
_SMALLEST_BLOCK = 512
_MOST_SEALS = 10
"""Number of possible seals that are tried; a document has one."""
_SHORT = 8
"""Hexadecimal digits of the digest of a block, which locates changes; the whole digest proves them.
"""
_LONGEST = 200 + MOST_BLOCKS * _SHORT
"""Bytes of the end that holds a seal: its words, digest and size take less than 200."""
_SEAL = rb"sha256 ([0-9a-f]{64}) blocks ([1-9]\d{0,9}) ([0-9a-f]*)"


@dataclass(frozen=True)
class _Form:
    """How a kind of document includes its seal: what surrounds it, in place of `opened`."""

    before: bytes
    after: bytes
    opened: bytes = b""
    """End of a document without a seal, if the seal is put inside."""

    def line(self, seal: bytes) -> bytes:
        """Return the end of a sealed document."""
        return self.before + seal + self.after


FORMS = {
    ".json": _Form(b',\n "seal": "', b'"\n}\n', b"\n}\n"),
    ".html": _Form(b"<!-- seal: ", b" -->\n"),
    ".pdf": _Form(b"% seal: ", b"\n"),
}
"""Kinds of documents with a seal, by suffix."""


@dataclass(frozen=True)
class BrokenPart:
    """A changed range of bytes; `end` is exclusive."""

    start: int
    end: int


def seal(content: bytes, suffix: str) -> bytes:
    """Return a document with its seal; raise DataError for a kind without seals."""
    form = _form(suffix)
    if not content.endswith(form.opened):
        raise DataError(f"this {suffix} document does not end as one that can be sealed")
    body = content.removesuffix(form.opened)
    return body + form.line(_seal_of(body))


def unsealed(content: bytes, suffix: str) -> bytes:
    """Return a document without its seal; one without a seal unchanged."""
    form = _form(suffix)
    match = _find(content, form)
    return content if match is None else content[: match.start()] + form.opened


def check_seal(content: bytes, suffix: str) -> list[BrokenPart]:
    """Return the changed parts of a sealed document, in order.

    Raises DataError for a missing or damaged seal.
    """
    match = _find(content, _form(suffix))
    if match is None:
        raise DataError(
            "there is no seal at its end, or the seal itself was changed",
            hint="the last line of a certificate holds the SHA-256 of all lines before it",
        )
    body = content[: match.start()]
    digest, size, blocks = match[1].decode(), int(match[2]), match[3].decode()
    if content == body + _form(suffix).line(_seal_of(body)):
        return []
    parts = _broken(body, size, blocks)
    if hashlib.sha256(body).hexdigest() == digest or not parts:
        raise DataError("the seal itself was changed: its digests contradict each other")
    return parts


def issued_part(content: bytes, suffix: str) -> bytes:
    """Return a document as issued, without later additions.

    A PDF can be signed by standard means (PAdES), which append to it: its seal is then in the
    middle. Any other document, and one without a seal, is returned unchanged.
    """
    form = _form(suffix)
    if suffix != ".pdf" or _find(content, form) is not None:
        return content
    ends = [match.end() for match in islice(_pattern(form).finditer(content), _MOST_SEALS)]
    intact = (end for end in ends if not check_seal(content[:end], suffix))
    end = next(intact, ends[0] if ends else len(content))
    return content[:end]


def _seal_of(body: bytes) -> bytes:
    size = max(_SMALLEST_BLOCK, -(-len(body) // MOST_BLOCKS))
    digest = hashlib.sha256(body).hexdigest()
    return f"sha256 {digest} blocks {size} {_blocks(body, size)}".encode()


def _broken(body: bytes, size: int, blocks: str) -> list[BrokenPart]:
    computed = _blocks(body, size)
    if len(computed) != len(blocks):  # bytes were added or taken away: all from there on is shifted
        length = min(len(computed), len(blocks))
        starts = range(0, length, _SHORT)
        first = next((at for at in starts if _at(computed, at) != _at(blocks, at)), 0)
        return [BrokenPart(first // _SHORT * size, len(body))]
    return [
        BrokenPart(at // _SHORT * size, min((at // _SHORT + 1) * size, len(body)))
        for at in range(0, len(computed), _SHORT)
        if _at(computed, at) != _at(blocks, at)
    ]


def _at(blocks: str, start: int) -> str:
    return blocks[start : start + _SHORT]


def _blocks(body: bytes, size: int) -> str:
    return "".join(
        hashlib.sha256(body[start : start + size]).hexdigest()[:_SHORT]
        for start in range(0, len(body), size)
    )


def _find(content: bytes, form: _Form) -> re.Match[bytes] | None:
    """Find the seal: it starts within the last bytes, and ends the document."""
    matches = _pattern(form).finditer(content, max(0, len(content) - _LONGEST))
    return next((match for match in matches if match.end() == len(content)), None)


def _pattern(form: _Form) -> re.Pattern[bytes]:
    return re.compile(re.escape(form.before) + _SEAL + re.escape(form.after))


def _form(suffix: str) -> _Form:
    if suffix not in FORMS:
        raise DataError(
            f"'{suffix}' is not a kind of certificate", hint=f"there are: {', '.join(FORMS)}"
        )
    return FORMS[suffix]
