"""Collect the problems of a procedure on a station, each once, with its place."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError, Problem, did_you_mean
from rigrunner.yamlfile.document import dotted

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path


class Problems:
    """The problems, in the order in which they were found."""

    def __init__(self) -> None:
        self._problems: dict[Problem, None] = {}

    def add(
        self, document: Document, path: Path, message: str, hint: str = "", *, key: bool = False,
        column: int = 0
    ) -> None:  # fmt: skip
        """Add a problem with the value (or key) at that path, unless it was added already.

        `column`: the character of a text, from 1, at which the problem is. 0 means the whole text.
        """
        origin = None if key else document.origin(path)
        written = f"it is written at {origin}" if origin else ""
        hints = "; ".join(part for part in (hint, written) if part)
        where = document.within(path, column) if column else document.where(path, key=key)
        problem = Problem(message, where, dotted(path), hints)
        self._problems[problem] = None

    def include(self, problems: Iterable[Problem]) -> None:
        """Add problems that were found elsewhere."""
        self._problems.update(dict.fromkeys(problems))

    def stop_if_any(self) -> None:
        """Raise InvalidFileError with all problems, if there are any."""
        if self._problems:
            raise InvalidFileError(self._problems)


def suggestion(name: str, known_names: Iterable[str], what: str) -> str:
    """Return the most similar name, or a list of the names that exist."""
    names = list(known_names)
    return did_you_mean(name, names, f"{what}: {', '.join(names) or 'none'}")
