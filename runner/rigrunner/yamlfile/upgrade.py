"""Convert texts in an older form of the language to the current form.

Edits are made in the text itself, so comments stay. Only the current form is read. Texts that are
stored in old runs are converted here first.
"""

from __future__ import annotations

import shlex
from textwrap import indent
from typing import TYPE_CHECKING, Any

import yaml

from rigrunner.api.errors import InvalidFileError, Location, Problem
from rigrunner.yamlfile import layout
from rigrunner.yamlfile.document import dotted
from rigrunner.yamlfile.reader import parse
from rigrunner.yamlfile.upgrade_register import (
    STATION,
    current_station,
    edited_station,
    is_older,
    older_entries,
)
from rigrunner.yamlfile.validation import MARK

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.yamlfile.document import Document

CURRENT = {"procedure/1": "procedure/2"}
"""Older forms, each with the form that replaces it."""
_MARKS_WITH_LIMITS = {"procedure/1", "procedure/2", "acceptance/1"}
"""The kinds of file whose `acceptance` may have the older form, which had limits of torque only."""
_OF_TORQUE = (None, "mean", "each_frequency")
"""What such a limit applies to: torque was the only result."""
TORQUE, FREQUENCY = "torque", "frequency"
_NESTED, _ITEM = 4, 2
"""The indentation of the keys of an entry: of an entry with a name, and of one without."""
_FIRST_TRAVEL = "5 deg"
"""The window of `starts: {}` in procedure/1."""


def upgraded(text: str, name: str) -> str:
    """Return a text in the current form. A text that has it already is returned unchanged.

    `name` stands for the file in messages. Raises InvalidFileError for a text that is not YAML, or
    whose layout cannot be edited.
    """
    data = parse(text, name).data
    mark = _mark_of(data)
    is_station = mark == STATION and is_older(data)
    if mark not in CURRENT and not _older_limits(data) and not is_station:
        return text
    try:
        new = edited_station(text, data) if is_station else _current_text(text, data)
        expected = current_station(data) if is_station else _current_content(data)
        # The text is edited by its layout, the content apart from that: they check each other.
        is_right = parse(new, name).data == expected
    except (ValueError, InvalidFileError):
        is_right = False
    if not is_right:
        part = "register" if is_station else "acceptance"
        message = f"its {part} cannot be upgraded in this layout"
        if mark in CURRENT:
            message = f"it cannot be upgraded from '{mark}' to '{CURRENT[mark]}' in this layout"
        hint = "write each key and its value as 'key: value', or change the file by hand"
        raise InvalidFileError([Problem(message, Location(name), hint=hint)])
    return new


def upgraded_acceptance(acceptance: object) -> object:
    """Return the limits and the rule of an older document in the current form."""
    if not isinstance(acceptance, dict) or not (older := _older_in(acceptance)):
        return acceptance
    limits = acceptance.get("limits") or [acceptance["limit"]]
    excluded = [hz for limit in older for hz in _list(limit.get("at"))]
    upgraded_limits = [_limit(limit, excluded) if limit in older else limit for limit in limits]
    others = {key: value for key, value in acceptance.items() if key not in {"limit", "limits"}}
    return {"limits": upgraded_limits, **others}


def refuse_older(document: Document) -> None:
    """Raise InvalidFileError, with the command to type, for a file in an older form."""
    data = document.data
    mark = _mark_of(data)
    hint = f"type 'rigrunner upgrade {shlex.quote(document.name)}'"
    if mark in CURRENT:
        message = f"got '{mark}', an older form of the language, expected '{CURRENT[mark]}'"
        raise InvalidFileError([Problem(message, document.where((MARK,)), MARK, hint)])
    if mark == STATION and is_older(data):
        entry = ("instruments", next(older_entries(data)), "errors")
        message = "got an older form of the register, expected the errors under 'accuracy'"
        at = document.where(entry, key=True)
        raise InvalidFileError([Problem(message, at, dotted(entry), hint)])
    if _older_limits(data):
        path = ("acceptance", "limit" if "limit" in data["acceptance"] else "limits")
        message = "got an older form of limits, expected a list 'limits', each 'of' a result"
        at = document.where(path, key=True)
        raise InvalidFileError([Problem(message, at, ".".join(path), hint)])


def _mark_of(data: object) -> str:
    """Return what a file says that it is; '' for none, or for what is no text."""
    mark = data.get(MARK) if isinstance(data, dict) else None
    return mark if isinstance(mark, str) else ""


def _older_limits(data: object) -> list[dict[str, Any]]:
    """Return the limits in the older form that a file has."""
    if not isinstance(data, dict) or _mark_of(data) not in _MARKS_WITH_LIMITS:
        return []
    acceptance = data.get("acceptance")
    return _older_in(acceptance) if isinstance(acceptance, dict) else []


def _older_in(acceptance: dict[str, Any]) -> list[dict[str, Any]]:
    if "limits" not in acceptance and isinstance(acceptance.get("limit"), dict):
        return [acceptance["limit"]]
    limits = [limit for limit in _list(acceptance.get("limits")) if isinstance(limit, dict)]
    return [limit for limit in limits if "measurand" in limit and limit.get("of") in _OF_TORQUE]


def _list(value: object) -> list[Any]:
    return value if isinstance(value, list) else [] if value is None else [value]


def _limit(limit: dict[str, Any], excluded: list[Any]) -> dict[str, Any]:
    """Return an older limit in the current form.

    `excluded` are the frequencies with a limit of their own.
    """
    new: dict[str, Any] = {"of": TORQUE}
    if limit.get("of", "mean") == "mean":
        new["mean"] = "yes"
    elif "at" in limit:
        new |= {"each": FREQUENCY, "where": {FREQUENCY: limit["at"]}}
    else:
        new |= {"each": FREQUENCY} | ({"except": {FREQUENCY: excluded}} if excluded else {})
    return new | {key: value for key, value in limit.items() if key not in {"of", "at"}}


def _current_content(data: dict[str, Any]) -> dict[str, Any]:
    """Return the content that a text is to have in the current form."""
    current = {**data, MARK: CURRENT.get(data[MARK], data[MARK])}
    if "acceptance" in data:
        current["acceptance"] = upgraded_acceptance(data["acceptance"])
    if data[MARK] in CURRENT and isinstance(data.get("analysis"), dict):
        analysis = data["analysis"]
        starts = analysis.get("starts")
        others = {key: value for key, value in analysis.items() if key != "starts"}
        current["analysis"] = [{"swing_torque": analysis}] if analysis else []
        if starts is not None:
            settings = {**(starts or {"window": _FIRST_TRAVEL}), **others}
            current["analysis"] = [{"breakaway": settings}]
    return current


def _current_text(text: str, data: dict[str, Any]) -> str:
    """Return the text with its edits. Raises ValueError where its layout cannot be edited."""
    if older := _older_limits(data):
        text = _with_limits(text, data["acceptance"], older)
    if data[MARK] not in CURRENT:
        return text
    _, value = layout.pair_at(text, (MARK,))
    begin = text.index(value.value, value.start_mark.index)
    text = layout.splice(text, begin, begin + len(value.value), CURRENT[data[MARK]])
    analysis = data.get("analysis")
    if not isinstance(analysis, dict):
        return text
    if not analysis:
        _, value = layout.pair_at(text, ("analysis",))
        return layout.splice(text, value.start_mark.index, value.end_mark.index, "[]")
    if analysis.get("starts") is None:
        return _with_listed_analysis(text, "swing_torque")
    return _with_listed_analysis(_without_starts(text), "breakaway")


def _with_limits(text: str, acceptance: dict[str, Any], older: list[dict[str, Any]]) -> str:
    """Return the text with each older limit as a limit of the torque, in a list."""
    single = "limits" not in acceptance
    _, value = layout.pair_at(text, ("acceptance", "limit" if single else "limits"))
    nodes = [value] if single else list(value.value)
    limits = [acceptance["limit"]] if single else acceptance["limits"]
    excluded = [
        layout.source(text, hz)
        for node, limit in zip(nodes, limits, strict=True)
        if limit in older and limit.get("of") == "each_frequency"
        for hz in _frequencies(node)
    ]
    edits = [
        edit
        for node, limit in zip(nodes, limits, strict=True)
        if limit in older
        for edit in _limit_edits(text, node, excluded)
    ]
    for start, end, new in sorted(edits, reverse=True):  # from the end: earlier places stay
        text = layout.splice(text, start, end, new)
    return _with_one_item(text) if single else text


def _frequencies(limit: yaml.Node) -> list[yaml.Node]:
    at = next((value for key, value in limit.value if key.value == "at"), None)
    if at is None:
        return []
    return list(at.value) if isinstance(at, yaml.SequenceNode) else [at]


def _limit_edits(
    text: str, limit: yaml.Node, excluded: list[str]
) -> Iterator[tuple[int, int, str]]:
    """Yield the edits that turn an older limit into one of the torque: start, end, new text."""
    keys = {key.value: (key, value) for key, value in limit.value}
    first = limit.value[0][0]
    # As the keys beside it are: a file may be JSON, which is YAML too.
    quote = '"' if first.style == '"' else ""
    separator = (
        ", "
        if layout.is_flow(limit)
        else f"{layout.line_end_of(text)}{' ' * first.start_mark.column}"
    )

    def pair(key: str, value: str, *, plain: bool = True) -> str:
        shown = f"{quote}{value}{quote}" if plain else value
        return f"{quote}{key}{quote}: {shown}"

    def at(values: str) -> str:
        return f"{{{quote}{FREQUENCY}{quote}: {values}}}"

    pairs = [pair("of", TORQUE)]
    if "of" not in keys or keys["of"][1].value == "mean":
        pairs.append(pair("mean", "yes"))
    else:
        pairs.append(pair("each", FREQUENCY))
        if "at" not in keys and excluded:
            pairs.append(pair("except", at(f"[{', '.join(excluded)}]"), plain=False))
    if "of" in keys:
        key, value = keys["of"]
        yield key.start_mark.index, value.end_mark.index, separator.join(pairs)
    else:
        start = first.start_mark.index
        yield start, start, separator.join(pairs) + separator
    if "at" in keys:
        key, value = keys["at"]
        values = ", ".join(layout.source(text, frequency) for frequency in _frequencies(limit))
        if isinstance(value, yaml.SequenceNode):
            values = f"[{values}]"
        yield key.start_mark.index, layout.end_of(value), pair("where", at(values), plain=False)


def _with_one_item(text: str) -> str:
    """Return the text with the one limit as the only item of a list."""
    key, value = layout.pair_at(text, ("acceptance", "limit"))
    begin, stop = key.start_mark.index, key.end_mark.index
    quote = '"' if key.style == '"' else ""
    if layout.is_flow(value):
        start, end = value.start_mark.index, value.end_mark.index
        text = layout.splice(text, start, end, f"[{text[start:end]}]")
        return layout.splice(text, begin, stop, f"{quote}limits{quote}")
    first, last = layout.lines_below(text, key, value)
    at = value.start_mark.index
    margin, column = " " * _ITEM, " " * value.start_mark.column
    head = indent(text[first : at - len(column)], margin, lambda _: True)
    new = f"{head}{column}- {indent(text[at:last], margin)[_ITEM:]}"
    return layout.splice(layout.splice(text, first, last, new), begin, stop, "limits")


def _with_listed_analysis(text: str, name: str) -> str:
    """Return the text with the analysis as the one item of a list, under a name."""
    key, value = layout.pair_at(text, ("analysis",))
    start, end = value.start_mark.index, value.end_mark.index
    if layout.is_flow(value):
        quote = '"' if key.style == '"' else ""
        inner = f"{quote}{name}{quote}: {text[start:end]}"
        # Within braces, or over several lines, no block can begin.
        if layout.is_flow(layout.mapping_at(text, ())) or "\n" in text[key.start_mark.index : end]:
            return layout.splice(text, start, end, f"[{{{inner}}}]")
        colon = text.index(":", key.end_mark.index) + 1
        margin = " " * (key.start_mark.column + _ITEM)
        return layout.splice(text, colon, end, f"\n{margin}- {inner}")
    first, last = layout.lines_below(text, key, value)
    head = f"{' ' * value.start_mark.column}- {name}:{layout.line_end(text[first:last])}"
    return layout.splice(text, first, last, head + indent(text[first:last], " " * _NESTED))


def _without_starts(text: str) -> str:
    """Return the text with the keys under `starts` of the analysis in place of that key."""
    key, value = layout.pair_at(text, ("analysis", "starts"))
    start, end = key.start_mark.index, value.end_mark.index
    if not isinstance(value, yaml.MappingNode):
        return text
    if layout.is_flow(value):
        pairs = [text[k.start_mark.index : v.end_mark.index] for k, v in value.value]
        separator = (
            ", "
            if layout.is_flow(layout.mapping_at(text, ("analysis",)))
            else f"\n{' ' * key.start_mark.column}"
        )
        quote = '"' if key.style == '"' else ""
        pairs = pairs or [f"{quote}window{quote}: {quote}{_FIRST_TRAVEL}{quote}"]
        return layout.splice(text, start, end, separator.join(pairs))
    first, last = layout.lines_below(text, key, value)
    excess = value.start_mark.column - key.start_mark.column
    # A comment may be indented less than the keys.
    lines = [
        line[min(excess, len(line) - len(line.lstrip(" "))) :]
        for line in text[first:last].splitlines(keepends=True)
    ]
    begin = text.rindex("\n", 0, start) + 1
    comment = text[text.index(":", key.end_mark.index) + 1 : first].lstrip(" ")
    head = f"{' ' * key.start_mark.column}{comment}" if comment.strip() else ""
    return layout.splice(text, begin, last, head + "".join(lines))
