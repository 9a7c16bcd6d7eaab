"""Checks that a page shows its content: it is regenerated and compared.

A page that cannot be regenerated here is not proven: it needs a signature over its bytes. What is
visible in it is checked nevertheless.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import SequenceMatcher
from html import unescape
from typing import TYPE_CHECKING

from rigrunner.analysis.revisions import FIRST
from rigrunner.api.certificate import parse_certificate
from rigrunner.api.errors import DataError, MissingPackageError, RigrunnerError, UsageError
from rigrunner.api.hooks import CertificateFormatRecord
from rigrunner.api.letterhead import CertificateInput, Letterhead
from rigrunner.certificate.letterhead import FILE as LETTERHEAD_FILE
from rigrunner.certificate.letterhead import STYLE, read_letterhead
from rigrunner.documents.verifying.revisions import made_with
from rigrunner.proof.compare import mismatches
from rigrunner.proof.contents import without_content
from rigrunner.proof.places import place_in

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rigrunner.api.certificate import Certificate
    from rigrunner.documents.verifying.forms import Form
    from rigrunner.documents.verifying.verification import Verification
    from rigrunner.registry import Registry

KIND = "certificate_format"
_FIGURE = re.compile(rb'(?<=<img src=")data:image/svg\+xml;base64,[^"]*')
"""Drawings are ignored; their alternative text is compared."""
_LOGO = re.compile(rb'^<img class="logo" src="data:[^"<>]*" alt="[^"<>]*">$', re.MULTILINE)
_STYLE = re.compile(rb"(?<=<style>)[^<]*(?=</style>)")
_TEXT_FOLDERS = ("templates/", "texts/")
"""Files of a letterhead that change the words of a page."""
_HIDDEN = re.compile(r"<(?:script|style|title)\b[^<>]*>[^<]*", re.IGNORECASE)
_TAG = re.compile(r"<[^<>]*>")
_DECIMAL = re.compile(r"\d+\.\d+")
_LONGEST = 90
_MAX_LINE_RATIO = 3


class NotMadeAgainError(RigrunnerError):
    """A page cannot be regenerated here, and why."""


@dataclass(frozen=True, kw_only=True)
class PageMaker:
    """Makes the pages of one document again, as issued."""

    certificate: Certificate
    registry: Registry
    letterhead: Letterhead | None
    """As at the time of issue; None if unknown."""
    why: str = ""
    """Why it is unknown."""

    def page(self, suffix: str) -> bytes:
        """Return a page without its seal; raise NotMadeAgainError if that is impossible."""
        name = self._installed(suffix)
        if self.letterhead is None:
            raise NotMadeAgainError(self.why)
        return self._make(name, self.letterhead)

    def plain_page(self, suffix: str) -> bytes:
        """Return a page without the logo and style of the laboratory; raise as `page` does."""
        name, appearance = self._installed(suffix), self.certificate.appearance
        if any(file.startswith(_TEXT_FOLDERS) for file in appearance.files):
            raise NotMadeAgainError("the laboratory has texts or templates of its own")
        plain = Letterhead(self.certificate.laboratory, appearance.language, prefix="")
        return self._make(name, plain)

    def _installed(self, suffix: str) -> str:
        """Return the installed format of such pages, with the layout of the issue."""
        records = (self.registry.find(KIND, name).record for name in self.registry.names(KIND))
        formats = (record for record in records if isinstance(record, CertificateFormatRecord))
        record = next((candidate for candidate in formats if candidate.suffix == suffix), None)
        if record is None:
            raise NotMadeAgainError(f"no plugin makes {suffix}")
        layout = self.certificate.appearance.layouts.get(record.name, FIRST)
        if layout != record.revision:
            then = self.certificate.evidence.issued_with
            raise NotMadeAgainError(
                f"its layout has revision {layout}, installed is {record.revision};"
                f" {made_with(then, KIND, record.name, self.registry)} makes it again"
            )
        return record.name

    def _make(self, name: str, letterhead: Letterhead) -> bytes:
        try:
            make = self.registry.make(KIND, name, {})
            return bytes(make(CertificateInput(self.certificate, letterhead)))
        except RigrunnerError as error:
            raise NotMadeAgainError(str(error)) from error


def page_maker(
    verification: Verification, certificate: Certificate, registry: Registry, folder: Path | None
) -> PageMaker:
    """Return the maker of the pages of a document, with or without the laboratory's folder.

    The folder of the issue with another laboratory is a difference. Raises UsageError for a folder
    without letterhead.
    """
    letterhead, reason = None, ""
    try:
        letterhead = _letterhead(certificate, folder)
    except UsageError:
        raise
    except RigrunnerError as error:
        reason = str(error)
    if letterhead is not None and folder is not None:
        recorded, current = (
            {
                "laboratory": source.laboratory.model_dump(mode="json"),
                "statements": list(source.statements),
            }
            for source in (certificate, letterhead)
        )
        what = "laboratory and statements of the letterhead"
        verification.take(what, mismatches(recorded, current))
    return PageMaker(certificate=certificate, registry=registry, letterhead=letterhead, why=reason)


def _letterhead(certificate: Certificate, folder: Path | None) -> Letterhead:
    files, language = certificate.appearance.files, certificate.appearance.language
    if folder is None:
        own_files = [name for name in files if name != LETTERHEAD_FILE]
        if own_files:
            raise NotMadeAgainError(
                f"it shows the laboratory's own {', '.join(own_files)}, which is not available",
                hint="name the laboratory's folder with --letterhead, or its key with --trust",
            )
        return Letterhead(laboratory=certificate.laboratory, language=language, prefix="")
    letterhead = read_letterhead(folder, language)
    present = letterhead.files
    changed = [name for name in {**files, **present} if files.get(name) != present.get(name)]
    if changed:
        raise NotMadeAgainError(
            f"the letterhead in {folder} is not the one it was issued with:"
            f" {', '.join(sorted(changed))}"
        )
    return letterhead


def check_page(verification: Verification, form: Form, maker: PageMaker, *, signed: bool) -> None:
    """Make one page again and compare it; `signed`: a trusted key signed its bytes.

    Different words or structure are a difference. A page that cannot be regenerated, or has other
    drawings, is proven only by the signature.
    """
    what = f"{form.name} regenerated from its content"
    differences: list[str] = []
    try:
        expected = maker.page(form.suffix)
        compare = _compare_html if form.suffix == ".html" else _compare_pdf
        differences, reason = compare(form.page, expected)
    except NotMadeAgainError as error:
        reason = str(error)
        differences = list(_contradictions(form, maker))
    if differences:
        verification.take(what, differences)
    elif not reason:
        verification.held.append(what)
    elif signed:
        verification.held.append(f"{form.name} is as a trusted key signed it")
        verification.information.append(f"{form.name} was not regenerated: {reason}")
    else:
        verification.unproven.append(f"{form.name}: {reason}")


def _compare_html(shown: bytes, expected: bytes) -> tuple[list[str], str]:
    """Return differences in words and structure, and differences in drawings."""
    drawings_differ = _FIGURE.findall(shown) != _FIGURE.findall(expected)
    reason = "its figure differs from the one made here" if drawings_differ else ""
    return list(_different_lines(shown, expected)), reason


def _compare_pdf(shown: bytes, expected: bytes) -> tuple[list[str], str]:
    """Return differences in numbers, and differences in drawings: page, font or picture."""
    if shown == expected:
        return [], ""
    try:
        from rigrunner.proof.pdf import first_difference  # noqa: PLC0415  (an extra)

        where = first_difference(shown, expected, _same_certificate)
    except MissingPackageError as error:
        return [], str(error)
    except DataError as error:
        return [error.message], ""
    if not where:
        return [], ""
    reason = f"it differs from the page made here, first at {where}"
    return list(_different_numbers(shown, expected)), reason


def _contradictions(form: Form, maker: PageMaker) -> Iterator[str]:
    """Yield what a page that cannot be regenerated shows and its content does not give.

    Without logo and style of the laboratory its words are known; with its own texts and templates
    only that they show the results.
    """
    try:
        plain = maker.plain_page(form.suffix)
    except NotMadeAgainError:
        yield from _missing(form, maker.certificate)
        return
    if form.suffix == ".html":
        shown = _LOGO.sub(b"", form.page, count=1)
        if STYLE in maker.certificate.appearance.files:
            shown, plain = (_STYLE.sub(b"", page) for page in (shown, plain))
        yield from _different_lines(shown, plain)
    else:
        yield from _different_numbers(form.page, plain)


def _different_numbers(shown: bytes, expected: bytes) -> Iterator[str]:
    """Yield the decimal numbers on only one PDF; none if they cannot be read."""
    try:
        from rigrunner.proof.pdf import text_of  # noqa: PLC0415  (an extra)

        on_page, in_content = (
            set(_DECIMAL.findall(_plain(text_of(page)))) for page in (shown, expected)
        )
    except MissingPackageError:  # the page stays unproven nevertheless
        return
    except DataError as error:
        yield error.message
        return
    yield from (f"it shows '{n}', its content does not" for n in sorted(on_page - in_content))
    yield from (f"it does not show '{n}' of its content" for n in sorted(in_content - on_page))


def _same_certificate(one: bytes, other: bytes) -> bool:
    """Return whether two attachments have the same content; newer programs write more members."""
    return parse_certificate(one, "attachment") == parse_certificate(other, "attachment")


def _missing(form: Form, certificate: Certificate) -> Iterator[str]:
    """Yield results missing on a page that cannot be regenerated."""
    try:
        if form.suffix == ".html":
            text = _plain(_text_of_html(form.page))
        else:
            from rigrunner.proof.pdf import text_of  # noqa: PLC0415  (an extra)

            text = _plain(text_of(form.page))
    except MissingPackageError:  # the page stays unproven nevertheless
        return
    except DataError as error:
        yield error.message
        return
    results, measured = certificate.results, certificate.measured
    stated = (results.headline, *(point.torque for point in results.points)) if results else ()
    stated = (*stated, *(result.found for result in certificate.named))
    for words in dict.fromkeys(
        (
            certificate.number,
            *(text for result in stated for text in (result.printed, result.printed_uncertainty)),
            *(value.printed for value in (measured.values if measured else ())),
        )
    ):
        if not re.search(rf"(?<![\w.]){re.escape(words)}(?![\w])", text):
            yield f"it does not show '{words}' of its content"


def _text_of_html(page: bytes) -> str:
    return unescape(_TAG.sub(" ", _HIDDEN.sub(" ", page.decode("utf-8", "replace"))))


def _plain(text: str) -> str:
    """Return a text with the signs of numbers as in the content."""
    return re.sub(r"(?<=\d),(?=\d)", ".", text.replace("\N{MINUS SIGN}", "-"))


def _different_lines(shown: bytes, expected: bytes) -> Iterator[str]:
    shown_lines, expected_lines = _lines(shown), _lines(expected)
    # Beyond this ratio a search for the differing lines takes very long.
    if len(shown_lines) > _MAX_LINE_RATIO * len(expected_lines):
        yield f"it has {len(shown_lines)} lines, its content gives {len(expected_lines)}"
        return
    # autojunk would take lines that come often, as in tables, for noise.
    matcher = SequenceMatcher(None, shown_lines, expected_lines, autojunk=False)
    for tag, start, end, a, b in matcher.get_opcodes():
        if tag != "equal":
            shown_words = _words(b" ".join(shown_lines[start:end]))
            expected_words = _words(b" ".join(expected_lines[a:b]))
            is_line = start < len(shown_lines)
            at = max(shown.find(shown_lines[start]) if is_line else len(shown) - 1, 0)
            place = place_in(shown, ".html", at, at + 1)
            yield f"at {place} it shows {shown_words}, its content gives {expected_words}"


def _lines(page: bytes) -> list[bytes]:
    """Return the lines of a page without drawings and data.

    The other page was made from the data.
    """
    shown = without_content(_FIGURE.sub(b"", page))
    return [line for line in shown.splitlines() if line.strip()]


def _words(markup: bytes) -> str:
    words = re.sub(rb"<[^<>]*>", b" ", markup).split() or markup.split()
    text = b" ".join(words).decode(errors="replace")
    return f"'{text[:_LONGEST]}{'…' if len(text) > _LONGEST else ''}'"
