"""From a text in an older form of the language to today's, by edits of the text: comments stay.

What is read is today's form alone; the texts that old runs carry are brought into it here.
"""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Any

import yaml

from rigrunner.api.errors import InvalidFileError, Location, Problem
from rigrunner.yamlfile.reader import LOADER, parse
from rigrunner.yamlfile.validation import MARK

if TYPE_CHECKING:
    from rigrunner.yamlfile.document import Document

TODAY = {"procedure/1": "procedure/2"}
"""Older forms, each with the one that takes its place."""
_NESTED, _ITEM = 4, 2
"""How much further in the keys of an entry stand: of one with a name, and of one without."""
_FIRST_TRAVEL = "5 deg"
"""The window of `starts: {}` in procedure/1."""

Pair = tuple[yaml.ScalarNode, yaml.Node]


def upgraded(text: str, name: str) -> str:
    """Return a text in today's form: the text itself where it has that, or is of another kind.

    `name` stands for the file in messages. Raises InvalidFileError for what is not YAML, and for a
    text that is laid out so that it cannot be edited.
    """
    data = parse(text, name).data
    mark = data.get(MARK) if isinstance(data, dict) else None
    if mark not in TODAY:
        return text
    try:
        new = _edited(text, data)
        right = parse(new, name).data == _wanted(data)
    except (ValueError, InvalidFileError):
        right = False
    if not right:
        message = f"it cannot be brought from '{mark}' to '{TODAY[mark]}' as it is laid out"
        hint = "write each key and its value as 'key: value', or change the file by hand"
        raise InvalidFileError([Problem(message, Location(name), hint=hint)])
    return new


def refuse_older(document: Document) -> None:
    """Raise InvalidFileError, with the command to type, for a file in an older form."""
    mark = document.data.get(MARK) if isinstance(document.data, dict) else None
    if mark in TODAY:
        message = f"got '{mark}', an older form of the language, expected '{TODAY[mark]}'"
        hint = f"type 'rigrunner upgrade {shlex.quote(document.name)}'"
        raise InvalidFileError([Problem(message, document.where((MARK,)), MARK, hint)])


def _wanted(data: dict[str, Any]) -> dict[str, Any]:
    """Return what a text of procedure/1 is to say today."""
    now = {**data, MARK: TODAY[data[MARK]]}
    if isinstance(data.get("analysis"), dict):
        now["analysis"] = _analyses(data["analysis"])
    return now


def _analyses(analysis: dict[str, Any]) -> list[dict[str, Any]]:
    if not analysis:
        return []
    starts = analysis.get("starts")
    if starts is None:
        return [{"swing_torque": analysis}]
    rest = {key: value for key, value in analysis.items() if key != "starts"}
    return [{"breakaway": {**(starts or {"window": _FIRST_TRAVEL}), **rest}}]


def _edited(text: str, data: dict[str, Any]) -> str:
    """Return the text with its edits; ValueError where it is laid out in another way."""
    text = _with_header(text, TODAY[data[MARK]])
    analysis = data.get("analysis")
    return _with_analyses(text, analysis) if isinstance(analysis, dict) else text


def _with_header(text: str, mark: str) -> str:
    _, value = _pair(text, (MARK,))
    begin = text.index(value.value, value.start_mark.index)
    return _put(text, begin, begin + len(value.value), mark)


def _with_analyses(text: str, analysis: dict[str, Any]) -> str:
    if not analysis:
        _, value = _pair(text, ("analysis",))
        return _put(text, value.start_mark.index, value.end_mark.index, "[]")
    starts = analysis.get("starts") is not None
    inside = _without_level(text, ("analysis", "starts")) if starts else text
    return _as_item(inside, ("analysis",), "breakaway" if starts else "swing_torque")


def _as_item(text: str, path: tuple[str, ...], name: str) -> str:
    """Return the text with the mapping at a key as the one item of a list, under a name."""
    key, value = _pair(text, path)
    start, end = value.start_mark.index, value.end_mark.index
    if _is_flow(value):
        quote = '"' if key.style == '"' else ""
        inner = f"{quote}{name}{quote}: {text[start:end]}"
        if _is_flow(_mapping(text, path[:-1])) or "\n" in text[key.start_mark.index : end]:
            return _put(text, start, end, f"[{{{inner}}}]")
        colon = text.index(":", key.end_mark.index) + 1
        return _put(text, colon, end, f"\n{' ' * (key.start_mark.column + _ITEM)}- {inner}")
    first, last = _lines_below(text, key, value)
    lines = [
        f"{' ' * _NESTED}{line}" if line.strip() else line for line in _lines(text[first:last])
    ]
    head = f"{' ' * value.start_mark.column}- {name}:{_line_end(text[first:last])}"
    return _put(text, first, last, head + "".join(lines))


def _without_level(text: str, path: tuple[str, ...]) -> str:
    """Return the text with the keys of the mapping at a key beside that key, which goes."""
    key, value = _pair(text, path)
    start, end = key.start_mark.index, value.end_mark.index
    if not isinstance(value, yaml.MappingNode):
        return text
    if _is_flow(value):
        pairs = [text[k.start_mark.index : v.end_mark.index] for k, v in value.value]
        between = (
            ", " if _is_flow(_mapping(text, path[:-1])) else f"\n{' ' * key.start_mark.column}"
        )
        quote = '"' if key.style == '"' else ""
        pairs = pairs or [f"{quote}window{quote}: {quote}{_FIRST_TRAVEL}{quote}"]
        return _put(text, start, end, between.join(pairs))
    first, last = _lines_below(text, key, value)
    less = value.start_mark.column - key.start_mark.column
    lines = [
        line[min(less, len(line) - len(line.lstrip(" "))) :] for line in _lines(text[first:last])
    ]
    begin = text.rindex("\n", 0, start) + 1
    beside = text[text.index(":", key.end_mark.index) + 1 : first].lstrip(" ")
    head = f"{' ' * key.start_mark.column}{beside}" if beside.strip() else ""
    return _put(text, begin, last, head + "".join(lines))


def _pair(text: str, path: tuple[str, ...]) -> Pair:
    """Return the key and the value at that path, with their places in the text."""
    mapping = _mapping(text, path[:-1])
    return next((key, value) for key, value in mapping.value if key.value == path[-1])


def _mapping(text: str, path: tuple[str, ...]) -> yaml.MappingNode:
    node = _pair(text, path)[1] if path else yaml.compose(text, Loader=LOADER)
    if not isinstance(node, yaml.MappingNode):
        raise ValueError(f"no mapping at {path}")  # noqa: TRY004  (of a text)
    return node


def _is_flow(node: yaml.Node) -> bool:
    """Say whether a mapping or a list is written in braces or brackets."""
    return isinstance(node, yaml.CollectionNode) and bool(node.flow_style)


def _lines_below(text: str, key: yaml.Node, value: yaml.Node) -> tuple[int, int]:
    """Return where the lines of a block begin and end, with the comments in it and at its end."""
    first = text.index("\n", key.end_mark.index) + 1
    last = _after_line(text, len(text[: _last(value)].rstrip()))
    while text[last:] and _is_comment(
        text[last : _after_line(text, last)], value.start_mark.column
    ):
        last = _after_line(text, last)
    return first, last


def _is_comment(line: str, column: int) -> bool:
    return line.lstrip(" ").startswith("#") and len(line) - len(line.lstrip(" ")) >= column


def _after_line(text: str, index: int) -> int:
    end = text.find("\n", index)
    return len(text) if end < 0 else end + 1


def _last(node: yaml.Node) -> int:
    """Return where the last that is written of a value ends."""
    if isinstance(node, yaml.ScalarNode) or _is_flow(node):
        return int(node.end_mark.index)
    if isinstance(node, yaml.MappingNode):
        key, value = node.value[-1]
        return max(int(key.end_mark.index), _last(value))
    return _last(node.value[-1])


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def _line_end(text: str) -> str:
    return "\r\n" if text.endswith("\r\n") else "\n"


def _put(text: str, start: int, end: int, new: str) -> str:
    return text[:start] + new + text[end:]
