"""How far an analysis is, for whoever waits."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Is told how much of what is done."""

    def __call__(self, what: str, done: int, of: int) -> None:
        """Take note."""
        ...


def unseen(what: str, done: int, of: int) -> None:
    """Take no note."""
