"""The part of a document, as text, that a range of bytes belongs to."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

_JSON_MEMBER = re.compile(rb'^ "([^"\\]+)":', re.MULTILINE)
_HTML_HEADING = re.compile(
    rb"<h[1-4][^<>]*>(.{0,500}?)</h[1-4]>|<(style|head|script|svg)\b", re.DOTALL
)
_HTML_TAG = re.compile(rb"<[^<>]*>")
"""The patterns are bounded, since a forged document may lack an end."""
_PDF_OBJECT = re.compile(rb"(?:^|[\r\n])(\d+) 0 obj\b")
_PDF_PAGE = re.compile(rb"/Type\s*/Page\b")
_PDF_CONTENTS = re.compile(rb"/Contents\s+(\d+) 0 R")
_MOST = 4


def place_in(content: bytes, suffix: str, start: int, end: int) -> str:
    """Return the place of bytes in a JSON, HTML or PDF document: bytes, lines and sections."""
    line = content.count(b"\n", 0, start) + 1
    last = content.count(b"\n", 0, max(start, end - 1)) + 1
    lines = f", line {line}" if last == line else f", lines {line} to {last}"
    find = {".json": _json_members, ".html": _html_headings, ".pdf": _pdf_objects}[suffix]
    marks = [(0, "beginning"), *find(content), (len(content), "")]
    sections = list(
        dict.fromkeys(
            name for (at, name), (next_at, _) in pairwise(marks) if at < end and next_at > start
        )
    )
    omitted = len(sections) - _MOST
    more = f" and {omitted} more" if omitted > 0 else ""
    section_text = f" ({', '.join(sections[:_MOST])}{more})" if sections else ""
    return f"bytes {start} to {end - 1}{'' if suffix == '.pdf' else lines}{section_text}"


def _json_members(content: bytes) -> Iterator[tuple[int, str]]:
    for member in _JSON_MEMBER.finditer(content):
        yield member.start(), member[1].decode(errors="replace")


def _html_headings(content: bytes) -> Iterator[tuple[int, str]]:
    for heading in _HTML_HEADING.finditer(content):
        if heading[2]:
            yield heading.start(), f"<{heading[2].decode()}>"
        else:
            text = _HTML_TAG.sub(b"", heading[1]).decode(errors="replace")
            yield heading.start(), f"section '{' '.join(text.split())}'"


def _pdf_objects(content: bytes) -> Iterable[tuple[int, str]]:
    """Yield the objects of a PDF, contents of pages with the page number."""
    objects = list(_PDF_OBJECT.finditer(content))
    pages: dict[bytes, int] = {}
    for start, end in pairwise([match.start() for match in objects] + [len(content)]):
        body = content[start:end]
        drawn = _PDF_CONTENTS.search(body) if _PDF_PAGE.search(body) else None
        if drawn:
            pages.setdefault(drawn[1], len(pages) + 1)
    for match in objects:
        page = f", page {pages[match[1]]}" if match[1] in pages else ""
        yield match.start(), f"object {match[1].decode()}{page}"
