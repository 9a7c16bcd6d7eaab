"""Whether what a page shows follows from the content that it carries: it is made again."""

from __future__ import annotations

import hashlib
import re
from base64 import b64decode
from difflib import SequenceMatcher
from html import unescape
from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError
from rigrunner.api.hooks import CertificateFormatRecord
from rigrunner.api.letterhead import CertificateInput, Letterhead, Logo
from rigrunner.certificate.letterhead import read_letterhead
from rigrunner.proof.places import place_in
from rigrunner.proof.seal import unsealed
from rigrunner.workflow.provenance import software
from rigrunner.workflow.verifying.run import versions

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator
    from pathlib import Path

    from rigrunner.api.certificate import Certificate
    from rigrunner.registry import Registry
    from rigrunner.workflow.verifying.verification import Verification

KIND = "certificate_format"
_OWN_WORDS = ("templates/", "texts/", "style.css")
"""Files of a letterhead without which a page cannot be made again."""
_LOGO = re.compile(
    rb'^<img class="logo" src="data:([a-z/+]+);base64,([A-Za-z0-9+/=]*)" alt="([^"<>]*)">$',
    re.MULTILINE,
)
_FIGURE = re.compile(rb'(?<=<img src=")data:image/svg\+xml;base64,[^"]*')
"""Of the drawing alone: the words that tell it to who cannot see it stay, and are compared."""
_LONGEST = 90
_FAR_MORE = 3


def check_pages(
    found: Verification,
    page: Path,
    certificate: Certificate,
    registry: Registry,
    letterhead: Path | None,
) -> None:
    """Make the page at a path again from its content, and compare the two.

    With the laboratory's letterhead byte by byte; without it HTML line by line, but for the figure,
    and with the logo that the page shows if it is the one of the letterhead, by its digest. What
    keeps a page from being made again is told, and is no difference.
    """
    what = f"{page.name} made again from its content"
    if letterhead is None and page.suffix != ".html":
        found.information.append(
            f"the pages of {page.name} were not made again: its seal and the data in it were"
            " checked (--letterhead DIR makes them again)"
        )
        return
    shown = unsealed(page.read_bytes(), page.suffix)
    try:
        known = _letterhead(certificate, letterhead, shown)
        made = _make(page.suffix, registry, CertificateInput(certificate, known))
    except RigrunnerError as error:
        found.information.append(f"{page.name} was not made again: {error}")
        return
    whole = letterhead is not None
    differs = list(_differences(shown, made, page.suffix, whole=whole))
    if not whole and _FIGURE.findall(shown) != _FIGURE.findall(made):
        found.information.append(
            f"the figure in {page.name} is not drawn as it would be here: compare the two by eye"
        )
    other = list(versions(certificate.evidence.issued_with, software(registry), "was issued"))
    if differs and other:
        found.information.append(f"{what}: it differs, but so do versions ({'; '.join(other)})")
    else:
        found.take(what, differs)


def _letterhead(certificate: Certificate, folder: Path | None, shown: bytes) -> Letterhead:
    files, language = certificate.appearance.files, certificate.appearance.language
    if folder is not None:
        found = read_letterhead(folder, language)
        other = [
            name for name in {**files, **found.files} if files.get(name) != found.files.get(name)
        ]
        if other:
            raise RigrunnerError(
                f"the letterhead in {folder} is not the one it was issued with:"
                f" {', '.join(sorted(other))}"
            )
        return found
    own = [name for name in files if name.startswith(_OWN_WORDS)]
    if own:
        raise RigrunnerError(
            f"the laboratory has its own {', '.join(own)}", hint="name its folder with --letterhead"
        )
    logo = _logo_of(shown, files.values())
    return Letterhead(laboratory=certificate.laboratory, language=language, prefix="", logo=logo)


def _logo_of(page: bytes, digests: Collection[str]) -> Logo | None:
    """Return the logo that a page shows; None for a picture that is none of the letterhead's files.

    Then the page differs from one without: any other picture could hide what stands on the page.
    """
    found = _LOGO.search(page)
    if found is None:
        return None
    kind, packed, text = (each.decode("utf-8", "replace") for each in found.groups())
    try:
        content = b64decode(packed, validate=True)
    except ValueError:
        return None
    known = hashlib.sha256(content).hexdigest() in digests
    return Logo(content, kind, unescape(text)) if known else None


def _make(suffix: str, registry: Registry, given: CertificateInput) -> bytes:
    for name in registry.names(KIND):
        record = registry.find(KIND, name).record
        if isinstance(record, CertificateFormatRecord) and record.suffix == suffix:
            return bytes(registry.make(KIND, name, {})(given))
    raise RigrunnerError(f"no plugin makes {suffix}")


def _differences(shown: bytes, made: bytes, suffix: str, *, whole: bool) -> Iterator[str]:
    if suffix == ".html":
        yield from _different_lines(shown, made, whole=whole)
    elif shown != made:
        pairs = enumerate(zip(shown, made, strict=False))
        first = next((at for at, (one, other) in pairs if one != other), min(len(shown), len(made)))
        yield f"it differs from {place_in(shown, suffix, first, first + 1)} on"


def _different_lines(shown: bytes, made: bytes, *, whole: bool) -> Iterator[str]:
    ours, theirs = (_lines(page, whole=whole) for page in (shown, made))
    if len(ours) > _FAR_MORE * len(theirs):  # to say where would take very long
        yield f"it has {len(ours)} lines, its content gives {len(theirs)}"
        return
    for tag, start, end, a, b in SequenceMatcher(None, ours, theirs, autojunk=False).get_opcodes():
        if tag != "equal":
            there, wanted = (b" ".join(part) for part in (ours[start:end], theirs[a:b]))
            at = max(shown.find(ours[start]) if start < len(ours) else len(shown) - 1, 0)
            place = place_in(shown, ".html", at, at + 1)
            yield f"at {place} it shows {_words(there)}, its content gives {_words(wanted)}"


def _lines(page: bytes, *, whole: bool) -> list[bytes]:
    """Return the lines of a page; without the figure where that cannot be known."""
    kept = page if whole else _FIGURE.sub(b"", page)
    return [line for line in kept.splitlines() if line.strip()]


def _words(markup: bytes) -> str:
    words = re.sub(rb"<[^<>]*>", b" ", markup).split() or markup.split()
    text = b" ".join(words).decode(errors="replace")
    return f"'{text[:_LONGEST]}{'…' if len(text) > _LONGEST else ''}'"
