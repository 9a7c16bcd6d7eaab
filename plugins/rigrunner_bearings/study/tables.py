"""Tables and sentences of a study, for a terminal and in Markdown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from rigrunner.api.summaries import table

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table; without a title it belongs to the one before."""

    title: str = ""
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    sides: str
    """Alignment of the columns: a letter 'l' or 'r' for each."""


Part: TypeAlias = "Table | str"


def text(parts: Iterable[Part]) -> str:
    """Return the parts as text for a terminal."""
    return "\n\n".join(
        part
        if isinstance(part, str)
        else f"{part.title}\n{table(part.header, part.rows, part.sides)}".lstrip("\n")
        for part in parts
    )


def markdown(parts: Iterable[Part]) -> str:
    """Return the parts in Markdown."""
    return "\n\n".join(part if isinstance(part, str) else _markdown(part) for part in parts)


def _markdown(table: Table) -> str:
    lines = [table.header, ["---"] * len(table.header), *table.rows]
    title = f"### {table.title}\n\n" if table.title else ""
    return title + "\n".join(f"| {' | '.join(line)} |" for line in lines)
