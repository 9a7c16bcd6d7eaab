"""The tables in a file: a new one, or a page that has two marks, between which they stand."""

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
    """Write the sections, by name in the order given; a page keeps those not measured now."""
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    before, begin, tables_on = text.partition(f"{BEGIN}\n")
    old, end, after = tables_on.partition(END)
    page = bool(begin and end)
    earlier = dict.fromkeys(order, LATER) | stored(old) if page else {}
    merged = {**earlier, **sections}
    parts = [head, *(f"## {name}\n\n{merged[name]}" for name in order if name in merged)]
    tables = "\n\n".join(parts) + "\n"
    path.write_text(f"{before}{BEGIN}\n{tables}{END}{after}" if page else tables, encoding="utf-8")


def stored(tables: str) -> dict[str, str]:
    """Return the sections of a page, by name."""
    _, *parts = HEADING.split(tables)
    return {name: section.strip() for name, section in zip(parts[::2], parts[1::2], strict=True)}
