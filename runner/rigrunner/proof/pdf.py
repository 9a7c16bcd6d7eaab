"""Compares two PDF files by what they draw, and extracts the text of one.

Programs may number and compress objects in different ways. Files are therefore compared from the
catalogue down, object by object: page content, fonts, pictures, structure, links. Ignored are only
the names of the writing programs, and how objects are stored.
"""

from __future__ import annotations

import io
import logging
import operator
import re
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import DataError, MissingPackageError

try:
    from pypdf import PdfReader
    from pypdf.errors import PyPdfError
    from pypdf.generic import ArrayObject, DictionaryObject, IndirectObject, StreamObject
except ImportError as error:
    raise MissingPackageError(
        "PDF files cannot be compared: the package 'pypdf' is not installed",
        hint="pip install 'rigrunner[pdf]'",
    ) from error

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

logging.getLogger("pypdf").addHandler(logging.NullHandler())  # its warnings about forged files

_STORAGE = {"/Length", "/Filter", "/DecodeParms"}
_WRITERS = {"Producer", "ModifyDate", "MetadataDate", "xmptk"}
"""Metadata with the writing program and the time."""
_SYNTAX = {"id", "about", "begin"}
# Possessive quantifiers: in a forged file the search could otherwise take very long.
_TEXT = re.compile(r"<(?:\w++:)?(\w++)[^<>]*+>([^<>]++)</")
_ATTRIBUTE = re.compile(r'\s(?!xmlns\b)(?:\w++:)?(\w++)="([^"<>]*+)"')
_OBJECT = re.compile(rb"(?<![0-9])(\d+)[\0\t\n\f\r ]+\d+[\0\t\n\f\r ]+obj\b")
_DEEPEST = 500
"""Greatest depth of objects; a page tree or bookmarks are far less deep."""


def first_difference(
    shown: bytes, derived: bytes, same_data: Callable[[bytes, bytes], bool] = operator.eq
) -> str:
    """Return where two PDF files would draw differently; empty if nowhere.

    `same_data` returns whether two attached files have the same meaning. Raises DataError if a PDF
    file cannot be read.
    """
    with readable():
        ours, theirs = reader(shown), reader(derived)
        differences = _Comparison(same_data).differences(ours.root_object, theirs.root_object, "")
        return next(differences, "")


def text_of(content: bytes) -> str:
    """Return the text of all pages; raise DataError if they cannot be read."""
    with readable():
        return "\n".join(page.extract_text() for page in reader(content).pages)


def reader(content: bytes) -> PdfReader:
    """Return a reader of a file that all programs read alike; raise DataError for another.

    A program can use the tables of the file, or search the objects itself. Both must agree, since a
    forged file could show one thing to us and another to a person.
    """
    pdf = PdfReader(io.BytesIO(content), strict=True)
    tables = {number: at for entries in pdf.xref.values() for number, at in entries.items()}
    objects = {int(match[1]): match.start(1) for match in _OBJECT.finditer(content)}
    tables.pop(0, None)  # the head of the list of free objects
    if tables != objects or not content.startswith(b"%PDF-") or content.count(b"%PDF-") > 1:
        raise DataError("the PDF's tables do not list the objects in it")
    return pdf


@contextmanager
def readable() -> Iterator[None]:
    """Convert any exception of the reader of a damaged or forged file to a DataError."""
    try:
        yield
    except DataError:
        raise
    except (PyPdfError, RecursionError, MemoryError) as error:
        raise DataError(f"the PDF cannot be read: {error}") from error
    except Exception as error:  # a foreign file can make the reader raise anything
        raise DataError(f"the PDF cannot be read: {type(error).__name__}: {error}") from error


def metadata_texts(stream: StreamObject) -> list[tuple[str, str]]:
    """Return names and texts of XMP metadata, without writer and time.

    A property is an element, or an attribute with the same meaning.
    """
    text = stream.get_data().decode("utf-8", "replace")
    elements = (element for element in _TEXT.findall(text) if element[1].strip())
    texts = (*elements, *_ATTRIBUTE.findall(text))
    return sorted((name, words) for name, words in texts if name not in _WRITERS | _SYNTAX)


class _Comparison:
    """Compares two files; each pair of objects once."""

    def __init__(self, same_data: Callable[[bytes, bytes], bool]) -> None:
        self._same_data = same_data
        self._seen: set[tuple[int, int]] = set()

    def differences(self, one: Any, other: Any, where: str, depth: int = 0) -> Iterator[str]:
        if depth > _DEEPEST:
            raise DataError(f"the PDF cannot be read: it is nested too deeply at {where}")
        if isinstance(one, IndirectObject) and isinstance(other, IndirectObject):
            # Objects refer to each other in circles, such as a page and its parent.
            pair = (one.idnum, other.idnum)
            if pair in self._seen:
                return
            self._seen.add(pair)
        one, other = _value(one), _value(other)
        if type(one) is not type(other):
            yield where or "the catalogue"
        elif isinstance(one, DictionaryObject):
            yield from self._of_dictionaries(one, other, where, depth)
        elif isinstance(one, ArrayObject):
            if len(one) != len(other):
                yield where
                return
            for index, (ours, theirs) in enumerate(zip(one, other, strict=True)):
                yield from self.differences(ours, theirs, f"{where}/{index}", depth + 1)
        elif one != other:
            yield where

    def _of_dictionaries(self, one: Any, other: Any, where: str, depth: int) -> Iterator[str]:
        streams = isinstance(one, StreamObject) and isinstance(other, StreamObject)
        if streams and one.get("/Type") == "/Metadata":
            if metadata_texts(one) != metadata_texts(other):
                yield where
            return
        attached = streams and one.get("/Type") == other.get("/Type") == "/EmbeddedFile"
        # Params has size and dates of an attachment, whose content is compared itself.
        left_out = (_STORAGE if streams else set()) | ({"/Params"} if attached else set())
        for key in sorted((one.keys() | other.keys()) - left_out):
            place = f"{where}{key}"
            if key not in one or key not in other:
                yield place
            else:
                ours, theirs = one.raw_get(key), other.raw_get(key)
                yield from self.differences(ours, theirs, place, depth + 1)
        same = self._same_data if attached else operator.eq
        if streams and not same(one.get_data(), other.get_data()):
            yield where


def _value(item: Any) -> Any:
    return item.get_object() if isinstance(item, IndirectObject) else item
