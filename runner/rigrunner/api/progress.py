"""Progress of an analysis."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """A callback for progress."""

    def __call__(self, what: str, done: int, of: int) -> None:
        """Report that `done` of `of` parts of `what` are done."""
        ...


def unseen(what: str, done: int, of: int) -> None:
    """Ignore the progress."""
