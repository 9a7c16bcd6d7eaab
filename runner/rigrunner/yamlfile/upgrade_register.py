"""Convert the register of a station from its older form.

There the errors of a torque transducer stood under `errors`, beside `accuracy`. They are parts of
`accuracy` now.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import yaml

from rigrunner.yamlfile import layout

if TYPE_CHECKING:
    from collections.abc import Iterator

STATION = "station/1"
_INDENT = 2


def is_older(data: object) -> bool:
    """Return whether a station has an entry in the older form."""
    return any(True for _ in older_entries(data))


def older_entries(data: object) -> Iterator[int]:
    """Yield the entries of a station that are in the older form."""
    entries = data.get("instruments") if isinstance(data, dict) else None
    for index, entry in enumerate(entries if isinstance(entries, list) else ()):
        if isinstance(entry, dict) and isinstance(entry.get("errors"), dict):
            yield index


def current_station(data: Any) -> Any:
    """Return the content of a station in the current form."""
    if not is_older(data):
        return data
    entries = list(data["instruments"])
    for index in older_entries(data):
        entry = entries[index]
        accuracy = entry.get("accuracy") or {}
        parts = {"overall": accuracy} if isinstance(accuracy, str) else accuracy
        others = {key: value for key, value in entry.items() if key not in {"accuracy", "errors"}}
        entries[index] = {**others, "accuracy": {**parts, **entry["errors"]}}
    return {**data, "instruments": entries}


def edited_station(text: str, data: Any) -> str:
    """Return the text of a station with its edits. Raises ValueError where it cannot be edited."""
    for index in reversed(list(older_entries(data))):
        _, entries = layout.pair_at(text, ("instruments",))
        entry = entries.value[index]
        if not isinstance(entry, yaml.MappingNode):
            raise ValueError(f"no mapping at {index}")  # noqa: TRY004  (of a text)
        keys = {key.value: (key, value) for key, value in entry.value}
        edits = list(_edits(text, entry, keys))
        for start, end, new in sorted(edits, reverse=True):
            text = layout.splice(text, start, end, new)
    return text


def _edits(
    text: str, entry: yaml.MappingNode, keys: dict[str, layout.Pair]
) -> Iterator[tuple[int, int, str]]:
    """Yield the edits that move `errors` into `accuracy`: start, end, new text."""
    errors_key, errors = keys["errors"]
    if "accuracy" not in keys:
        yield errors_key.start_mark.index, errors_key.end_mark.index, "accuracy"
        return
    key, accuracy = keys["accuracy"]
    if layout.is_flow(entry):
        parts = [*_pairs(text, accuracy), *_pairs(text, errors)]
        yield accuracy.start_mark.index, accuracy.end_mark.index, f"{{{', '.join(parts)}}}"
        start, end = errors_key.start_mark.index, layout.end_of(errors)
        # The comma before it goes too, if it is its own.
        comma = text.rindex(",", 0, start)
        yield (comma, end, "") if not text[comma + 1 : start].strip() else (start, end, "")
        return
    indent = " " * (key.start_mark.column + _INDENT)
    ending = layout.line_end_of(text)
    parts = [*_lines(text, key, accuracy, indent), *_lines(text, errors_key, errors, indent)]
    start, end = _extent(text, key, accuracy)
    colon = text.index(":", key.end_mark.index) + 1
    comment = _trailing_comment(text, key, accuracy)
    suffix = f"  {comment}" if comment else ""
    yield colon, end, suffix + ending + "".join(f"{line}{ending}" for line in parts)
    yield (*_extent(text, errors_key, errors), "")


def _pairs(text: str, value: yaml.Node) -> list[str]:
    """Return each key with its value as they are written.

    A text alone is the error over the whole range.
    """
    if not isinstance(value, yaml.MappingNode):
        return [f"overall: {layout.source(text, value)}"]
    return [text[k.start_mark.index : layout.end_of(v)] for k, v in value.value]


def _lines(text: str, key: yaml.Node, value: yaml.Node, indent: str) -> list[str]:
    """Return the lines of a value, indented as a block, with the comments among them."""
    if layout.is_flow(value) or not isinstance(value, yaml.MappingNode):
        return [indent + pair for pair in _pairs(text, value)]
    first, last = layout.lines_below(text, key, value)
    indented = value.start_mark.column
    lines = [line.rstrip("\r\n") for line in text[first:last].splitlines(keepends=True)]
    return [indent + line[indented:] if line[:indented].strip() == "" else line for line in lines]


def _extent(text: str, key: yaml.Node, value: yaml.Node) -> tuple[int, int]:
    """Return where the lines of a key and its value begin and end."""
    start = text.rfind("\n", 0, key.start_mark.index) + 1
    if isinstance(value, yaml.MappingNode) and not layout.is_flow(value):
        return start, layout.lines_below(text, key, value)[1]
    end = text.find("\n", layout.end_of(value))
    return start, len(text) if end < 0 else end + 1


def _trailing_comment(text: str, key: yaml.Node, value: yaml.Node) -> str:
    """Return the comment on the line of a key, or after a value of one line."""
    block = isinstance(value, yaml.MappingNode) and not layout.is_flow(value)
    start = key.end_mark.index + 1 if block else layout.end_of(value)
    line = text[start : text.find("\n", start) if "\n" in text[start:] else len(text)].strip()
    return line if line.startswith("#") else ""
