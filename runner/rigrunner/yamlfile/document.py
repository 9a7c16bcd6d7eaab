"""A YAML document as a plain tree, with the place of every key and value."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import Location

if TYPE_CHECKING:
    from collections.abc import Mapping

Path = tuple[str | int, ...]
"""The way to a value in the tree: keys and indices from the root."""


@dataclass(frozen=True)
class Marks:
    """Line and column, from 1, of a value and of its key. The key of a list item is the item."""

    value: tuple[int, int]
    key: tuple[int, int]
    begins: int = 0
    """Where the value begins in the text of the file, counted in characters from 0."""


@dataclass(frozen=True, eq=False)
class Document:
    """A document's tree of dicts, lists and scalars, and the place of each part."""

    name: str
    data: Any
    marks: Mapping[Path, Marks]
    origins: Mapping[Path, Path] = field(default_factory=dict)
    """The origins of values that were copied from elsewhere in this document."""
    given: Mapping[Path, tuple[Document, Path]] = field(default_factory=dict)
    """The origins of values that were copied from another document."""
    text: str = ""
    """The text of the file, unchanged."""

    def where(self, path: Path, *, key: bool = False) -> Location:
        """Return the place of the value, or of its key.

        If it is absent, return that of its nearest parent.
        """
        for length in range(len(path), -1, -1):
            if path[:length] in self.given:
                document, source = self.given[path[:length]]
                return document.where(source + path[length:], key=key)
            marks = self.marks.get(path[:length])
            if marks is not None:
                return Location(self.name, *(marks.key if key else marks.value))
        return Location(self.name)

    def within(self, path: Path, column: int) -> Location:
        """Return the place of a character, counted from 1, of the text at a path.

        For a text that comes from elsewhere it is the place of the whole text.
        """
        value, marks = self.part(path), self.marks.get(path)
        is_copied = any(path[:length] in self.given or path[:length] in self.origins
                        for length in range(len(path) + 1))  # fmt: skip
        if not isinstance(value, str) or marks is None or is_copied or not self.text:
            return self.where(path)
        index = marks.begins
        if self.text[index : index + 1] in {"|", ">"}:  # a block: its text begins on the next line
            index = self.text.find("\n", index)
        # YAML folds lines and takes indentation off, so white space tells nothing of the place.
        for character in value[: column - 1]:
            if not character.isspace():
                index = self.text.find(character, index) + 1
                if not index:  # written as an escape
                    return self.where(path)
        while self.text[index : index + 1].isspace() or self.text[index : index + 1] in {"'", '"'}:
            index += 1
        line = self.text.count("\n", 0, index)
        return Location(self.name, line + 1, index - self.text.rfind("\n", 0, index))

    def origin(self, path: Path) -> Location | None:
        """Return where a value that is here by reference was written, or None."""
        for length in range(len(path), 0, -1):
            source = self.origins.get(path[:length])
            if source is not None:
                return self.where(source + path[length:])
        return None

    def part(self, path: Path) -> Any:
        """Return the subtree at that path, or None where there is none."""
        node = self.data
        for step in path:
            if not has_part(node, step):
                return None
            node = node[step]
        return node


def has_part(node: object, step: object) -> bool:
    """Return whether a mapping has that key, or a list that index."""
    if isinstance(node, dict):
        return step in node
    return isinstance(node, list) and isinstance(step, int) and 0 <= step < len(node)


def dotted(path: Path) -> str:
    """Return a path in the form `main[1].sweep.over`."""
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    return text.removeprefix(".")
