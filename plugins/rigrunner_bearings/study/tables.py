"""What a study prints, tables and sentences: for a terminal, and in Markdown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from rigrunner.api.summaries import table

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table; without a title it stands below the one before."""

    title: str = ""
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    sides: str
    """How each column is aligned, letter by letter of 'l' and 'r'."""


Part: TypeAlias = "Table | str"


def text(parts: Iterable[Part]) -> str:
    """Return the parts as a terminal shows them."""
    return "\n\n".join(
        each
        if isinstance(each, str)
        else f"{each.title}\n{table(each.header, each.rows, each.sides)}".lstrip("\n")
        for each in parts
    )


def markdown(parts: Iterable[Part]) -> str:
    """Return the parts as a page of documentation has them."""
    return "\n\n".join(each if isinstance(each, str) else _markdown(each) for each in parts)


def _markdown(each: Table) -> str:
    lines = [each.header, ["---"] * len(each.header), *each.rows]
    title = f"### {each.title}\n\n" if each.title else ""
    return title + "\n".join(f"| {' | '.join(line)} |" for line in lines)
