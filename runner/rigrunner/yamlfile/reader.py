"""Read a file into a Document. Any file gives a document or a message within a second."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import yaml

from rigrunner.api.errors import InvalidFileError, Location, Problem
from rigrunner.api.texts import TURNING, name_of
from rigrunner.yamlfile.composer import TOO_DEEP, compose

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.yamlfile.document import Document

MAX_BYTES = 1_000_000
_UTF8_BOM = b"\xef\xbb\xbf"
_UTF16_BOMS = (b"\xff\xfe", b"\xfe\xff")
_OTHER_KINDS = {
    b"%PDF": "a PDF",
    b"PK\x03\x04": "a ZIP archive or an office document",
    b"\x89HDF": "an HDF5 file",
    b"\x89PNG": "a picture",
}
"""How files of other programs begin."""
_NOT_TEXT = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x84\x86-\x9f\ud800-\udfff\ufffe\uffff" + f"{TURNING}]"
)
"""Characters that no text file may have, not even in a comment. U+0085 ends a line in YAML."""
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def read(path: Path) -> Document:
    """Return the document in that file. Raises InvalidFileError with all problems."""
    return parse(read_text(path), str(path))


def read_text(path: Path) -> str:
    """Return the file's text without its byte order mark. Raises InvalidFileError."""
    name = str(path)
    try:
        with path.open("rb") as file:
            # One byte more shows that a file is too large, without all of it.
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise _error(name, f"cannot be read: {error.strerror or error}") from error
    if len(content) > MAX_BYTES:
        raise _too_large(name)
    return _decode(content, name)


def parse(text: str, name: str) -> Document:
    """Return the document in a text. `name` stands for the file in messages.

    Raises InvalidFileError with all problems.
    """
    if len(text) > MAX_BYTES:
        raise _too_large(name)
    match = _NOT_TEXT.search(text)
    if match:
        message = f"the character {name_of(match[0])} is not allowed in a text file"
        turning = re.match(f"[{TURNING}]", match[0])
        hint = "it changes the text direction: remove it" if turning else "is this a YAML file?"
        raise _error(name, message, _position(text, match.start()), hint)
    try:
        return compose(yaml.parse(text, Loader=LOADER), text, name)
    except yaml.MarkedYAMLError as error:
        raise _syntax_error(error, text, name) from error


def _decode(content: bytes, name: str) -> str:
    if content.startswith(_UTF16_BOMS):
        raise _error(name, "the file is UTF-16, not UTF-8", hint="save it as UTF-8")
    for beginning, kind in _OTHER_KINDS.items():
        if content.startswith(beginning):
            raise _error(name, f"this is {kind}, not a text file", hint="name the YAML file")
    body = content.removeprefix(_UTF8_BOM)
    try:
        return body.decode("utf-8")
    except UnicodeDecodeError as error:
        before = body[: error.start].decode("utf-8")
        message = f"the byte 0x{body[error.start]:02X} is not UTF-8"
        place = _position(before, len(before))
        raise _error(name, message, place, "save the file as UTF-8") from error


def _syntax_error(error: yaml.MarkedYAMLError, text: str, name: str) -> InvalidFileError:
    mark = error.problem_mark or error.context_mark
    if mark is None:
        return _error(name, f"not YAML: {error.problem or error.context}")
    lines = text.splitlines()
    line = lines[mark.line] if mark.line < len(lines) else ""
    place = (mark.line + 1, mark.column + 1)
    if "nesting depth" in str(error.problem):  # PyYAML 6.0.4 and newer have a limit of their own
        return _error(name, TOO_DEEP, place)
    if "\t" in line[: len(line) - len(line.lstrip())]:
        return _error(name, "a tab indents this line", place, "indent with spaces")
    hints = (_syntax_hint(line, mark.column, str(error.problem)), _beginning(error, name))
    message = f"not YAML: {error.problem or error.context}"
    return _error(name, message, place, "; ".join(hint for hint in hints if hint))


def _syntax_hint(line: str, column: int, problem: str) -> str:
    if line[column : column + 1] in {"%", "@", "`"}:
        return f"put a text that begins with {line[column]} in quotes"
    if "mapping values" in problem:
        if ": " not in line[:column]:
            return "check the indentation of this line and of the one before"
        return "put a text that holds ': ' in quotes"
    if "end of stream" in problem:
        return "a quote or bracket is not closed"
    if "expected" in problem:
        return "check indentation, commas, brackets and quotes"
    return ""


def _beginning(error: yaml.MarkedYAMLError, name: str) -> str:
    """Return the start of the quote, list or mapping in which the error was found."""
    mark = error.context_mark
    if mark is None or not error.context or "token" in error.context:
        return ""
    what = error.context.removeprefix("while ").replace("parsing", "in").replace("scanning", "in")
    return f"{what} that begins at {Location(name, mark.line + 1, mark.column + 1)}"


def _position(text: str, index: int) -> tuple[int, int]:
    line_start = text.rfind("\n", 0, index) + 1
    return text.count("\n", 0, index) + 1, index - line_start + 1


def _too_large(name: str) -> InvalidFileError:
    return _error(name, f"the file is larger than {MAX_BYTES:,} bytes", hint="is it the right one?")


def _error(
    name: str, message: str, place: tuple[int, int] | None = None, hint: str = ""
) -> InvalidFileError:
    location = Location(name, *place) if place else Location(name)
    return InvalidFileError([Problem(message, location, hint=hint)])
