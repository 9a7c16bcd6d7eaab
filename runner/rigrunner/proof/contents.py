"""The content in the file of a certificate: the JSON itself, or the JSON in a page."""

from __future__ import annotations

import re
import zlib
from itertools import islice
from typing import TYPE_CHECKING

from rigrunner.api.certificate import parse_certificate
from rigrunner.api.errors import DataError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.certificate import Certificate

_SCRIPT = re.compile(
    rb'<script\b[^<>]*\btype="application/json"[^<>]*>([^<]*)</script>', re.IGNORECASE
)
"""Its text has no '<', so nothing in it can end it; the search is bounded."""
_ATTACHMENT = re.compile(rb"/EmbeddedFile\b.{0,2000}?stream\r?\n", re.DOTALL)
_LONGEST = 50_000_000  # bytes that are unpacked: few compressed ones can stand for very many
_MOST = 100
"""Number of attachments that are tried; a certificate has one."""


def content_in(content: bytes, suffix: str, name: str) -> Certificate:
    """Return the certificate in a JSON, HTML or PDF file, without its seal; raise DataError."""
    if suffix == ".json":
        certificate = parse_certificate(content, name)
    else:
        in_html = (script[1] for script in _SCRIPT.finditer(content))
        text = next(in_html if suffix == ".html" else _in_pdf(content), None)
        if text is None:
            raise DataError(f"{name} carries no content of a certificate")
        certificate = parse_certificate(text, name)
    return certificate.model_copy(update={"seal": None})


def without_content(page: bytes) -> bytes:
    """Return an HTML page without the content that `content_in` reads from it."""
    script = _SCRIPT.search(page)
    return page if script is None else page[: script.start(1)] + page[script.end(1) :]


def _in_pdf(content: bytes) -> Iterator[bytes]:
    """Yield the JSON attachments, which a PDF stores compressed or not."""
    for attachment in islice(_ATTACHMENT.finditer(content), _MOST):
        data = content[attachment.end() :]
        try:
            text = zlib.decompressobj().decompress(data, _LONGEST)
        except zlib.error:
            text = data.partition(b"endstream")[0]
        if text.lstrip().startswith(b"{"):
            yield text
