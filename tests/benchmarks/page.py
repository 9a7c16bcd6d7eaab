"""Writes the tables to a new file, or between the two marks of a page."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

BEGIN, END = "<!-- tables: begin -->", "<!-- tables: end -->"
LATER = "Not measured yet."
HEADING = re.compile(r"^## (.+)\n\n", re.MULTILINE)


def write(path: Path, head: str, sections: Mapping[str, str], order: Sequence[str]) -> None:
    """Write the sections in this order; a page keeps sections that were not measured now."""
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    before, begin, tables_on = text.partition(f"{BEGIN}\n")
    old, end, after = tables_on.partition(END)
    is_page = bool(begin and end)
    earlier = dict.fromkeys(order, LATER) | stored(old) if is_page else {}
    merged = {**earlier, **sections}
    parts = [head, *(f"## {name}\n\n{merged[name]}" for name in order if name in merged)]
    tables = "\n\n".join(parts) + "\n"
    path.write_text(
        f"{before}{BEGIN}\n{tables}{END}{after}" if is_page else tables, encoding="utf-8"
    )


def stored(tables: str) -> dict[str, str]:
    """Return the sections of a page, by name."""
    _, *parts = HEADING.split(tables)
    return {name: section.strip() for name, section in zip(parts[::2], parts[1::2], strict=True)}
