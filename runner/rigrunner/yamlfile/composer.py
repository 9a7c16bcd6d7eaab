"""Build a tree with places from the events of the YAML parser, with limits on its size.

libyaml's own composer recurses in C without a limit and resolves aliases and tags. Building the
tree from its events here avoids both.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any, NoReturn

import yaml

from rigrunner.api.errors import InvalidFileError, Location, Problem
from rigrunner.api.texts import TURNING, name_of, refused_character
from rigrunner.yamlfile.document import Document, Marks, Path, dotted

if TYPE_CHECKING:
    from collections.abc import Iterator


MAX_DEPTH = 40
"""No file of ours is half as deep, and recursion over it stays far from the limit of Python."""
TOO_DEEP = f"nested more than {MAX_DEPTH} deep"
MAX_VALUES = 20_000  # what is read within a second
MAX_PROBLEMS = 50
_CONSTANTS: dict[str, bool | None] = {
    "": None, "~": None, "null": None, "Null": None, "NULL": None,
    "true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False,
}  # fmt: skip
_INTEGER = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")
_LEADING_ZERO = re.compile(r"[-+]?0+[0-9]")
_MAX_DIGITS = 40
"""Characters of a number: a double has 17 digits, and of thousands Python takes long."""
_LONGEST = 40
"""Letters of a key in a message."""
_TURNING = re.compile(f"[{TURNING}]")
_MERGE = "<<"
_DIGITS_THEN_TEXT = re.compile(r"[0-9]+\b.*")


class ScalarError(ValueError):
    """A scalar that has two possible meanings, or none."""

    def __init__(self, message: str, hint: str) -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint


def read_plain(text: str) -> bool | float | str | None:
    """Return the value of an unquoted scalar, by the core schema of YAML 1.2.

    Raises ScalarError for its ambiguous forms.
    """
    if text in _CONSTANTS:
        return _CONSTANTS[text]
    if _NOT_FINITE.fullmatch(text):
        raise ScalarError(f"{text} is not a finite number", "write a finite number")
    if _FLOAT.fullmatch(text):
        return _number(text)
    return text


def _number(text: str) -> float:
    if len(text) > _MAX_DIGITS:
        raise ScalarError(f"a number of {len(text)} characters", "put it in quotes if it is a text")
    if _LEADING_ZERO.match(text):
        bare = re.sub(r"^([-+]?)0+(?=[0-9])", r"\1", text)
        hint = f"write {bare} for the number, or '{text}' in quotes for the text"
        raise ScalarError(f"{text} has a leading zero", hint)
    value = int(text) if _INTEGER.fullmatch(text) else float(text)
    if not math.isfinite(value):
        raise ScalarError(f"{text} is too large a number", "write a smaller number")
    return value


def compose(events: Iterator[yaml.Event], text: str, name: str) -> Document:
    """Return the one document that the events describe. Raises InvalidFileError."""
    return _Composer(events, text, name).document()


class _Composer:
    def __init__(self, events: Iterator[yaml.Event], text: str, name: str) -> None:
        self._events = events
        self._text = text
        self._name = name
        self._marks: dict[Path, Marks] = {}
        self._problems: list[Problem] = []

    def document(self) -> Document:
        """Return the document. Raises InvalidFileError with all problems that were found."""
        self._next(yaml.StreamStartEvent)
        if isinstance(next(self._events), yaml.StreamEndEvent):
            self._stop("the file is empty", None, "was it saved? 'rigrunner init' creates examples")
        first = next(self._events)
        data = self._value(first, (), first)
        self._next(yaml.DocumentEndEvent)
        end = next(self._events)
        if not isinstance(end, yaml.StreamEndEvent):
            self._stop("a second document begins here", end, hint="one file, one document")
        if self._problems:
            raise InvalidFileError(self._problems)
        return Document(self._name, data, self._marks, text=self._text)

    def _value(self, event: yaml.Event, path: Path, key: yaml.Event) -> Any:
        if len(path) > MAX_DEPTH:
            self._stop(TOO_DEEP, event)
        if len(self._marks) >= MAX_VALUES:
            self._stop(f"the file has more than {MAX_VALUES:,} values", event)
        begins = event.start_mark.index if event.start_mark else 0
        self._marks[path] = Marks(_place(event), _place(key), begins)
        self._check_anchor_and_tag(event, path)
        if isinstance(event, yaml.MappingStartEvent):
            return self._mapping(path)
        if isinstance(event, yaml.SequenceStartEvent):
            return self._sequence(path)
        return self._scalar(event, path)

    def _check_anchor_and_tag(self, event: yaml.Event, path: Path) -> None:
        anchor, tag = getattr(event, "anchor", None), getattr(event, "tag", None)
        if isinstance(event, yaml.AliasEvent):
            hint = "write the value out, or use a parameter: $name"
            self._report(f"the alias *{anchor} is not allowed", event, path, hint)
        elif anchor is not None:
            self._report(f"the anchor &{anchor} is not allowed", event, path, "leave it out")
        if tag is not None:
            self._report(f"the tag {tag} is not allowed", event, path, "put text in quotes")

    def _check_escaped(
        self, event: yaml.ScalarEvent, path: Path, match: re.Match[str] | None
    ) -> None:
        """Report a forbidden character that is written as an escape.

        Control characters are allowed in values: a serial line may end with one. Texts refuse them.
        """
        if match:
            self._report(f"it holds the character {name_of(match[0])}", event, path, "remove it")

    def _mapping(self, path: Path) -> dict[str, Any]:
        mapping: dict[str, Any] = {}
        first: dict[str, Location] = {}
        while not isinstance(event := next(self._events), yaml.MappingEndEvent):
            value_event = next(self._events)
            previous = next(reversed(mapping.values()), None)
            key = self._key(event, value_event, path, previous)
            location = Location(self._name, *_place(event))
            if first.setdefault(key, location) != location:
                message = f"the key '{_clip(key)}' is given twice; first at {first[key]}"
                self._report(message, event, path)
            mapping[key] = self._value(value_event, (*path, key), event)
        return mapping

    def _key(self, event: yaml.Event, value: yaml.Event, path: Path, before: object) -> str:
        self._check_anchor_and_tag(event, path)
        if not isinstance(event, yaml.ScalarEvent):
            self._stop("a key has to be a text", event)
        self._check_escaped(event, path, refused_character(event.value))
        text = _clip(event.value)
        if self._splits_value(event, value):
            self._report_comma(before, text, event, path)
        elif event.value == _MERGE and event.implicit[0]:
            hint = "write the keys out, or use a parameter: $name"
            self._report("the merge key << is not allowed", event, path, hint)
        elif event.implicit[0] and not isinstance(_read_or_none(event.value), str):
            message = f"the key {text or '(empty)'} is not a text"
            self._report(message, event, path, f"put it in quotes: '{text}'")
        return str(event.value)

    def _sequence(self, path: Path) -> list[Any]:
        items: list[Any] = []
        while not isinstance(event := next(self._events), yaml.SequenceEndEvent):
            value = self._value(event, (*path, len(items)), event)
            if items and self._splits_number(items[-1], value, event):
                self._report_comma(items[-1], value, event, path)
            items.append(value)
        return items

    def _scalar(self, event: yaml.Event, path: Path) -> Any:
        if not isinstance(event, yaml.ScalarEvent):
            return None  # an alias, which was reported
        if not event.implicit[0]:  # in quotes: always a text
            self._check_escaped(event, path, _TURNING.search(event.value))
            return event.value
        try:
            return read_plain(event.value)
        except ScalarError as error:
            self._report(error.message, event, path, error.hint)
            return None

    def _splits_value(self, key: yaml.ScalarEvent, value: yaml.Event) -> bool:
        """Return whether `{max: 1,5 N}` was written, which YAML reads as max: 1 and '5 N': null."""
        return (
            isinstance(value, yaml.ScalarEvent)
            and value.implicit[0]
            and not value.value
            and _DIGITS_THEN_TEXT.fullmatch(key.value) is not None
            and self._character_before(key) == ","
        )

    def _splits_number(self, before: object, value: object, event: yaml.Event) -> bool:
        """Return whether `[1,5 N]` was written, which YAML reads as 1 and '5 N'."""
        return (
            isinstance(before, int)
            and isinstance(value, str)
            and _DIGITS_THEN_TEXT.fullmatch(value) is not None
            and self._character_before(event) == ","
        )

    def _character_before(self, event: yaml.Event) -> str:
        index = event.start_mark.index if event.start_mark else 0
        return self._text[index - 1 : index]

    def _next(self, expected: type[yaml.Event]) -> None:
        event = next(self._events)
        if not isinstance(event, expected):
            self._stop("not YAML", event)

    def _report(self, message: str, event: yaml.Event, path: Path, hint: str = "") -> None:
        location = Location(self._name, *_place(event))
        self._problems.append(Problem(message, location, dotted(path), hint))
        if len(self._problems) >= MAX_PROBLEMS:
            self._stop("more problems follow; fix these first", event)

    def _report_comma(self, before: object, after: str, event: yaml.Event, path: Path) -> None:
        number = before if isinstance(before, int) else ""
        message = f"there is a decimal comma before '{_clip(after)}'"
        self._report(message, event, path, f"write a point: '{number}.{_clip(after)}'")

    def _stop(self, message: str, event: yaml.Event | None, hint: str = "") -> NoReturn:
        location = Location(self._name, *(_place(event) if event else ()))
        raise InvalidFileError([*self._problems, Problem(message, location, hint=hint)])


def _place(event: yaml.Event) -> tuple[int, int]:
    mark = event.start_mark
    return (mark.line + 1, mark.column + 1) if mark else (1, 1)


def _read_or_none(text: str) -> bool | float | str | None:
    try:
        return read_plain(text)
    except ScalarError:
        return None


def _clip(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
