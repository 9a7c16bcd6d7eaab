"""The figures of a benchmark as a Markdown table, aligned for terminals."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from benchmarks.frame import Figure, Spread, Target

HEADER = ("", "what", "median (quartiles)", "ratio to the floor", "target", "met", "note")
VERDICTS = {True: "yes", False: "**no**", None: ""}


def table(figures: Sequence[Figure]) -> str:
    rows = [HEADER, *(row(figure) for figure in figures)]
    widths = [max(len(cells[column]) for cells in rows) for column in range(len(HEADER))]
    lines = [line(cells, widths) for cells in rows]
    return "\n".join([lines[0], line(["-" * width for width in widths], widths), *lines[1:]])


def line(cells: Sequence[str], widths: Sequence[int]) -> str:
    padded = (cell.ljust(width) for cell, width in zip(cells, widths, strict=True))
    return f"| {' | '.join(padded)} |"


def row(figure: Figure) -> tuple[str, ...]:
    value = f"{spread(figure.value)} {figure.unit}".strip() if figure.value else ""
    ratio = spread(figure.ratio) if figure.ratio else ""
    cells = (figure.role, figure.what, value, ratio, target(figure.target))
    return (*cells, VERDICTS[figure.met()], figure.note)


def spread(value: Spread) -> str:
    if value.low == value.high:
        return number(value.median)
    return f"{number(value.median)} ({number(value.low)} .. {number(value.high)})"


def target(aim: Target | None) -> str:
    return f"{'≥' if aim.at_least else '≤'} {number(aim.bound)} {aim.unit}".strip() if aim else ""


def number(value: float) -> str:
    """Return three significant digits, with thousands separators and few powers of ten."""
    if value == 0 or not 1e-3 <= abs(value) < 1e9:
        return f"{value:.3g}"
    decimals = next((places for places in (2, 1, 0) if abs(value) < 10 ** (3 - places)), 0)
    return f"{value:,.{decimals}f}" if abs(value) >= 1 else f"{value:.3g}"
