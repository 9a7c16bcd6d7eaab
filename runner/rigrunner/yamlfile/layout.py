"""Find the parts of a YAML text, so that an edit keeps its comments and layout."""

from __future__ import annotations

import yaml

from rigrunner.yamlfile.reader import LOADER

Pair = tuple[yaml.ScalarNode, yaml.Node]


def pair_at(text: str, path: tuple[str, ...]) -> Pair:
    """Return the key and the value at that path, with their places in the text."""
    mapping = mapping_at(text, path[:-1])
    return next((key, value) for key, value in mapping.value if key.value == path[-1])


def mapping_at(text: str, path: tuple[str, ...]) -> yaml.MappingNode:
    """Return the mapping at that path. Raises ValueError where there is none."""
    node = pair_at(text, path)[1] if path else yaml.compose(text, Loader=LOADER)
    if not isinstance(node, yaml.MappingNode):
        raise ValueError(f"no mapping at {path}")  # noqa: TRY004  (of a text)
    return node


def is_flow(node: yaml.Node) -> bool:
    """Return whether a mapping or a list is written in braces or brackets."""
    return isinstance(node, yaml.CollectionNode) and bool(node.flow_style)


def lines_below(text: str, key: yaml.Node, value: yaml.Node) -> tuple[int, int]:
    """Return the first and last line of a block, with the comments in it and at its end."""
    first = text.index("\n", key.end_mark.index) + 1
    last = _after_line(text, len(text[: end_of(value)].rstrip()))
    while last < len(text):
        end = _after_line(text, last)
        words = text[last:end].lstrip(" ")
        if not words.startswith("#") or end - last - len(words) < value.start_mark.column:
            break
        last = end
    return first, last


def _after_line(text: str, index: int) -> int:
    end = text.find("\n", index)
    return len(text) if end < 0 else end + 1


def end_of(node: yaml.Node) -> int:
    """Return where the last written part of a value ends."""
    if isinstance(node, yaml.ScalarNode) or is_flow(node):
        return int(node.end_mark.index)
    # The parser ends a block at the next token, behind the comments and empty lines below it.
    if isinstance(node, yaml.MappingNode):
        key, value = node.value[-1]
        return max(int(key.end_mark.index), end_of(value))
    return end_of(node.value[-1])


def line_end_of(text: str) -> str:
    """Return the line end that a text uses."""
    return "\r\n" if "\r\n" in text else "\n"


def line_end(text: str) -> str:
    """Return the line end of that line."""
    return "\r\n" if text.endswith("\r\n") else "\n"


def splice(text: str, start: int, end: int, new: str) -> str:
    """Return the text with the part between two places replaced."""
    return text[:start] + new + text[end:]


def source(text: str, node: yaml.Node) -> str:
    """Return a value as it is written."""
    return text[node.start_mark.index : node.end_mark.index]
