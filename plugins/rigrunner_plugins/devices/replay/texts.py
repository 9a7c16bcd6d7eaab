"""YAML in which every value is a text, so that nothing is guessed: 'no' is no truth value here."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import yaml

from rigrunner.api import Location
from rigrunner.api.errors import InvalidFileError, Problem

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

MOST_BYTES = 1_000_000
"""Some ten thousand recordings."""
MOST_DEPTH = 20
"""A manifest needs five; far more than that would end in a RecursionError."""
Path_ = tuple[int | str, ...]


@dataclass(frozen=True)
class Texts:
    """Mappings, lists and texts, and the position of each."""

    data: Any
    file: str
    marks: Mapping[Path_, tuple[int, int]]

    def location(self, path: Sequence[int | str]) -> Location:
        """Return the position of the value at a path, or of the nearest one around it."""
        position = next(
            (self.marks[tuple(path[:n])] for n in range(len(path), -1, -1)
             if tuple(path[:n]) in self.marks), (1, 1),
        )  # fmt: skip
        return Location(self.file, *position)


def read_texts(path: Path) -> Texts:
    """Read a small YAML file; raise InvalidFileError for what is not plain and unambiguous.

    Refused: aliases, duplicate keys, keys that are no texts, depth, size, and wrong encoding.
    """
    file = str(path)
    try:
        source = path.read_bytes()
        if len(source) > MOST_BYTES:
            raise _invalid(f"is larger than {MOST_BYTES} bytes", Location(file))
        text = source.decode()
        _check_events(text, file)
        node = yaml.compose(text, Loader=yaml.SafeLoader)
    except UnicodeDecodeError:
        raise _invalid("is not UTF-8", Location(file)) from None
    except OSError as error:
        raise _invalid(f"cannot be read: {error.strerror}", Location(file)) from error
    except yaml.MarkedYAMLError as error:
        raise _invalid(f"not YAML: {error.problem}", _location(file, error)) from None
    except yaml.YAMLError as error:
        raise _invalid(f"not YAML: {error}", Location(file)) from None
    marks: dict[Path_, tuple[int, int]] = {}
    data = None if node is None else _plain(node, (), file, marks)
    return Texts(data, file, marks)


def _check_events(text: str, file: str) -> None:
    """Refuse before anything is composed what would take long or expand."""
    depth = 0
    for event in yaml.parse(text, Loader=yaml.SafeLoader):
        if isinstance(event, yaml.AliasEvent):
            raise _invalid("aliases are not allowed", _location(file, event))
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > MOST_DEPTH:
            raise _invalid("is nested too deeply", _location(file, event))


def _plain(node: yaml.Node, path: Path_, file: str, marks: dict[Path_, tuple[int, int]]) -> Any:
    marks[path] = (node.start_mark.line + 1, node.start_mark.column + 1)
    if isinstance(node, yaml.ScalarNode):
        return node.value
    if isinstance(node, yaml.SequenceNode):
        return [_plain(item, (*path, i), file, marks) for i, item in enumerate(node.value)]
    mapping: dict[str, Any] = {}
    for key, value in node.value:
        where = _location(file, key)
        if not isinstance(key, yaml.ScalarNode):
            raise _invalid("a key must be a text", where)
        if key.value in mapping:
            raise _invalid(f"the key '{key.value}' is given twice", where)
        mapping[key.value] = _plain(value, (*path, key.value), file, marks)
    return mapping


def _location(file: str, place: yaml.Node | yaml.Event | yaml.MarkedYAMLError) -> Location:
    mark = place.problem_mark if isinstance(place, yaml.MarkedYAMLError) else place.start_mark
    return Location(file, mark.line + 1, mark.column + 1) if mark else Location(file)


def _invalid(message: str, location: Location) -> InvalidFileError:
    return InvalidFileError([Problem(message, location)])
