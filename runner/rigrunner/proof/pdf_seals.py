"""What was appended to a PDF after it was issued: seals by standard means (PAdES), or other things.

Such a seal is an incremental update: the issued bytes stay as they are, and what follows them adds
a signature field, its signature and a new catalogue. The same mechanism could replace a page. So
every object that is new or redefined must be one of the few that a seal needs, and draw nothing.

Allowed are (ISO 32000-2, 12.7.5.5 and 12.8): in the catalogue a form that holds signature fields
alone, the store of validation data, version, extensions, permissions; on a page a field that is not
shown; in the metadata who wrote the file, and when.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pypdf.generic import (
    ArrayObject,
    DictionaryObject,
    IndirectObject,
    PdfObject,
    StreamObject,
)

from rigrunner.proof.pdf import metadata_texts, readable, reader

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from pypdf import PdfReader

_OF_CATALOGUE = {"/AcroForm", "/DSS", "/Extensions", "/Perms", "/Version"}
_OF_FORM = {"/Fields", "/SigFlags", "/DA", "/DR"}
_OF_INFO = {"/Producer", "/ModDate"}
_ACTIONS = {"/A", "/AA"}
_HIDDEN = 2
"""Flag bit of an annotation that hides it on screen and paper."""
_SEALS = {"/Sig", "/DocTimeStamp"}
_DIGESTS = ("sha256", "sha384", "sha512", "sha3_256", "sha3_384", "sha3_512")
"""Digests accepted for seals today (ETSI TS 119 312)."""


@dataclass
class Additions:
    """Additions of a PDF since it was issued."""

    changed: list[str] = field(default_factory=list)
    """Additions or changes that no seal makes: the document is another one."""
    drawn: list[str] = field(default_factory=list)
    """Seals that are drawn on a page: they can hide its content."""
    seals: list[str] = field(default_factory=list)
    """Names of the signed signature fields."""


def additions_to(issued: bytes, current: bytes) -> Additions:
    """Return the additions to an issued PDF; raise DataError if it cannot be read."""
    with readable():
        return _Appended(reader(issued), reader(current), issued, current).find()


class _Appended:
    def __init__(self, before: PdfReader, after: PdfReader, issued: bytes, current: bytes) -> None:
        self.before, self.after = before, after
        self.issued, self.current = issued, current
        self.result = Additions()

    def find(self) -> Additions:
        changed = self.result.changed
        allowed = self._allowed_changes()
        for name in ("/Root", "/Info"):
            if not _same(_raw(self.before.trailer, name), _raw(self.after.trailer, name)):
                changed.append(f"another object is the {name} of the file")
        if "/Encrypt" in self.after.trailer:
            changed.append("the file was encrypted")
        for number in self._numbers():
            before, after = self._object(self.before, number), self._object(self.after, number)
            if not _same(before, after):
                check = allowed.get(number)
                changed.extend(check(before, after) if check else [f"object {number} was changed"])
        self._check_form()
        if not self.result.seals:
            changed.append("what was appended is not a signature of the rest")
        return self.result

    def _allowed_changes(self) -> dict[int, Any]:
        """Return the check for each object that a seal may redefine, by number."""
        trailer = self.before.trailer
        catalogue = trailer.raw_get("/Root").idnum
        checks = {catalogue: self._of_catalogue}
        for of, name, check in (
            (trailer, "/Info", self._of_info),
            (self.before.root_object, "/Metadata", self._of_metadata),
        ):
            if isinstance(place := _raw(of, name), IndirectObject):
                checks[place.idnum] = check
        for index, page in enumerate(self.before.pages):
            assert page.indirect_reference is not None  # noqa: S101  (a page of a file has one)
            checks[page.indirect_reference.idnum] = self._of_page(index + 1)
        return checks

    def _numbers(self) -> Iterable[int]:
        numbers = {number for entries in self.before.xref.values() for number in entries}
        tables = {  # how a file stores its objects is no part of the document
            number
            for number in numbers
            if isinstance(stored := self._object(self.before, number), StreamObject)
            and stored.get("/Type") in ("/XRef", "/ObjStm")
        }
        return sorted((numbers | set(self.before.xref_objStm)) - tables - {0})

    @staticmethod
    def _object(of: PdfReader, number: int) -> PdfObject | None:
        return of.get_object(IndirectObject(number, 0, of))

    @staticmethod
    def _of_catalogue(before: DictionaryObject, after: DictionaryObject) -> Iterator[str]:
        for key in _different(before, after):
            if key in before or key not in _OF_CATALOGUE:
                yield f"{key} of the catalogue was changed"

    @staticmethod
    def _of_info(before: DictionaryObject, after: DictionaryObject) -> Iterator[str]:
        for key in _different(before, after):
            if key not in _OF_INFO:
                yield f"{key} of the document's information was changed"

    @staticmethod
    def _of_metadata(before: object, after: object) -> Iterator[str]:
        if (
            not isinstance(before, StreamObject)
            or not isinstance(after, StreamObject)
            or metadata_texts(before) != metadata_texts(after)
        ):
            yield "the metadata were changed"

    def _of_page(self, page: int) -> Any:
        def check(before_page: DictionaryObject, after_page: DictionaryObject) -> Iterator[str]:
            for key in _different(before_page, after_page):
                if key != "/Annots":
                    yield f"{key} of page {page} was changed"
            before, after = _items(before_page, "/Annots"), _items(after_page, "/Annots")
            if not all(map(_same, before, after)) or len(after) < len(before):
                yield f"an annotation of page {page} was changed"
            for item in after[len(before) :]:
                field = item.get_object()
                if not isinstance(field, DictionaryObject) or not _is_signature_field(field):
                    yield f"an annotation that is not a signature was added to page {page}"
                elif not _is_hidden(field):
                    name = field.get("/T", "")
                    self.result.drawn.append(f"the signature '{name}' on page {page}")

        return check

    def _check_form(self) -> None:
        if "/AcroForm" in self.before.root_object:
            return  # then it is an issued one, and was compared with the other objects
        form = self.after.root_object.get("/AcroForm")
        form = form.get_object() if form is not None else DictionaryObject()
        changed = self.result.changed
        changed.extend(f"the form has {key}" for key in form.keys() - _OF_FORM)
        for item in _items(form, "/Fields"):
            field = item.get_object()
            if not isinstance(field, DictionaryObject) or not _is_signature_field(field):
                changed.append("a field that is not a signature was added")
            elif self._is_signed(field):
                self.result.seals.append(str(field.get("/T", "")))

    def _is_signed(self, field: DictionaryObject) -> bool:
        """Return whether a field has a signature over everything issued."""
        value = field.get("/V")
        value = value.get_object() if value is not None else None
        if not isinstance(value, DictionaryObject) or value.get("/Type", "/Sig") not in _SEALS:
            return False
        spans = [int(number) for number in value.get("/ByteRange", ())]
        if len(spans) != 4:  # noqa: PLR2004  (two ranges, around the signature itself)
            return False
        start, length, after, tail = spans
        signed, gap = self.current[start : start + length], self.current[start + length : after]
        signed += self.current[after : after + tail]
        return (
            start == 0
            and len(self.issued) <= length < after
            and after + tail <= len(self.current)
            and gap.startswith(b"<")
            and gap.endswith(b">")
            and _names_digest_of(signed, gap)
        )


def _names_digest_of(signed: bytes, gap: bytes) -> bool:
    """Return whether the signature in a gap names a digest of the signed bytes (RFC 5652, 11.2).

    So it was made for these bytes. Its validity is not checked.
    """
    try:
        message = bytes.fromhex(gap[1:-1].decode("ascii"))
    except ValueError:  # no hexadecimal text, so no signature
        return False
    return any(hashlib.new(name, signed).digest() in message for name in _DIGESTS)


def _raw(of: DictionaryObject, key: str) -> PdfObject | None:
    return of.raw_get(key) if key in of else None


def _same(one: object, other: object) -> bool:
    """Return whether two objects are equal; references have numbers of their own."""
    if isinstance(one, IndirectObject) or isinstance(other, IndirectObject):
        return (
            isinstance(one, IndirectObject)
            and isinstance(other, IndirectObject)
            and (one.idnum, one.generation) == (other.idnum, other.generation)
        )
    if type(one) is not type(other):
        return False
    if isinstance(one, DictionaryObject) and isinstance(other, DictionaryObject):
        if isinstance(one, StreamObject) and isinstance(other, StreamObject):
            return not any(_different(one, other)) and one.get_data() == other.get_data()
        return not any(_different(one, other))
    if isinstance(one, ArrayObject) and isinstance(other, ArrayObject):
        return len(one) == len(other) and all(map(_same, one, other))
    return bool(one == other)


def _different(one: DictionaryObject, other: DictionaryObject) -> Iterator[str]:
    for key in sorted(one.keys() | other.keys()):
        in_both = key in one and key in other
        if not in_both or not _same(one.raw_get(key), other.raw_get(key)):
            yield key


def _items(of: DictionaryObject, key: str) -> list[PdfObject]:
    entries = of.get(key)
    entries = entries.get_object() if entries is not None else ()
    return list(entries) if isinstance(entries, (list, tuple)) else [DictionaryObject()]


def _is_signature_field(annotation: DictionaryObject) -> bool:
    return (
        annotation.get("/FT") == "/Sig"
        and annotation.get("/Subtype", "/Widget") == "/Widget"
        and not annotation.keys() & (_ACTIONS | {"/Kids", "/Parent"})
    )


def _is_hidden(annotation: DictionaryObject) -> bool:
    left, bottom, right, top = (float(edge) for edge in annotation.get("/Rect", (0, 0, 0, 0)))
    flags = int(annotation.get("/F", 0))
    return left == right or bottom == top or bool(flags & _HIDDEN)
