"""What a package reads in its own keys of a result document: for the terminal and comparisons."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rigrunner.api.coordinates import measured_column, with_unit, written_column
from rigrunner.api.readings import reading_text

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

    from rigrunner.api.data import Measurement

    Document = Mapping[str, Any]

GROUP = "rigrunner.summaries"
"""The group of the entry points of SummaryParts."""
GAP = "  "


@dataclass(frozen=True)
class SummaryParts:
    """What a package adds to the summary of a result document with its keys.

    An entry point of the group `rigrunner.summaries` names one.
    """

    facts: Callable[[Document], Iterable[tuple[str, str]]]
    """Returns named lines, which come before the verdict."""
    blocks: Callable[[Document], Iterable[str]]
    """Returns tables and paragraphs, which come after the verdict."""
    checks: Callable[[Document], Iterable[Document]]
    """Returns checks in keys of its own, in the form of `checks` of the document."""
    reads: Collection[str] = ()
    """The keys of its own. Those of result/1 that no installed package reads are reported."""
    results: Callable[[Document], Iterable[Document]] = lambda _: ()
    """Returns results in keys of its own: name, coordinates and estimate, as in `results` of the
    document. A `note` in the estimate says what its U covers, such as ' from scatter alone'; a
    value with a note is compared with that of another run, but is no result."""


def table(header: Sequence[str], rows: Sequence[Sequence[str]], right: str = "") -> str:
    """Return the rows under their header for a terminal, with columns as wide as their widest cell.

    `right` gives the alignment of each column by a letter 'l' or 'r'; left is the default.
    """
    lines = [list(header), *(list(row) for row in rows)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(header))]
    sides = right.ljust(len(header), "l")
    body = []
    for line in lines:
        cells = (
            cell.rjust(width) if side == "r" else cell.ljust(width)
            for cell, width, side in zip(line, widths, sides, strict=True)
        )
        body.append(GAP.join(cells).rstrip())
    rule = GAP.join("-" * width for width in widths)
    return "\n".join([body[0], rule, *body[1:]])


def pairs(rows: Sequence[tuple[str, str]]) -> str:
    """Return lines of name and value, with the values aligned, also of several lines."""
    width = max((len(name) for name, _ in rows), default=0)
    below = "\n" + " " * (width + len(GAP))
    return "\n".join(
        f"{name.ljust(width)}{GAP}{below.join(value.splitlines())}".rstrip() for name, value in rows
    )


def table_cells(rows: Sequence[Measurement]) -> tuple[list[str], list[list[str]]]:
    """Return the heads with units, and the cells of each row, of one table of measured values.

    First coordinates and set-points, then values, then readings that are not numbers.
    """
    units = {name: symbol for row in rows for name, symbol in row.units.items()}
    coordinates = dict.fromkeys(name for row in rows for name in row.coordinates)
    setpoints = dict.fromkeys(member for row in rows for member in row.setpoints)
    values = dict.fromkeys(member for row in rows for member in row.values)
    readings = dict.fromkeys(member for row in rows for member in row.readings)
    heads: list[str] = []
    columns: list[list[str]] = []
    for name in (*coordinates, *setpoints):
        symbol, column = written_column(rows, name, units.get(name, ""))
        heads.append(with_unit(name if name in coordinates else f"set {name}", symbol))
        columns.append(column)
    for member in values:
        symbol, column = measured_column(rows, member, units.get(member) or "1")
        heads.append(f"{member} / {symbol}" if symbol else member)
        columns.append(column)
    for member in readings:
        heads.append(with_unit(member, units.get(member, "")))
        columns.append([reading_text(row.readings.get(member, "")) for row in rows])
    return heads, [[column[row] for column in columns] for row in range(len(rows))]
