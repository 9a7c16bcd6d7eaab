"""The outcome of golden runs as text, for the terminal, JUnit files and reports."""

from __future__ import annotations

from math import floor, isinf, log10
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner_fleet.golden.comparing import Comparison, Move
    from rigrunner_fleet.golden.overall import Overall

SHOWN = 3
"""Figures of a run that are listed; the JSON has all."""

_MOST_DECIMALS = 8
"""Beyond these a number is written with six significant digits."""


def conclusion(overall: Overall) -> str:
    """Return the conclusion, in one line."""
    total, moved = len(overall.runs), len(overall.moved)
    runs = "1 golden run" if total == 1 else f"{total} golden runs"
    if not moved:
        return f"No change in {runs}"
    return f"{moved} of {runs} {'needs' if moved == 1 else 'need'} review"


def details(run: Comparison) -> Iterator[str]:
    """Yield the details of a run: reason, changed verdicts and checks, largest changes."""
    if run.problem:
        yield run.problem
    yield from run.flips.verdicts
    if run.before.method != run.after.method and run.after.method and run.before.method:
        yield f"method: {run.before.method} -> {run.after.method}"
    listed = [run.headline] if run.headline else []
    others = [move for move in run.moves if move not in listed]
    listed += others[: SHOWN - len(listed)]
    yield from map(move_text, listed)
    if len(run.moves) > len(listed):
        yield f"and {len(run.moves) - len(listed)} more figures"
    yield from run.flips.checks


def move_text(move: Move) -> str:
    """Return the change of a figure as text."""
    before, after = move.before, move.after
    if before is None or after is None:
        return f"{move.name}: {'is new' if before is None else 'is gone'}"
    unit = "" if after.unit == "1" else f" {after.unit}"
    then, now = (_number(figure.value, before.expanded) for figure in (before, after))
    shift = f" ({in_u(move.in_u)})" if move.shift else ""
    change_of_u = f", U {move.of_u:+.2%}" if move.of_u else ""
    return f"{move.name}: {then} -> {now}{unit}{shift}{change_of_u}"


def in_u(value: float | None) -> str:
    """Return a change as a multiple of the expanded uncertainty: '+0.12 U'."""
    if value is None:
        return "U unknown"
    if isinf(value):
        return "no U"
    digits = f"{value:+.2f}" if abs(value) >= 0.01 else f"{value:+.1e}"  # noqa: PLR2004  (two decimals)
    return f"{digits} U" if value else "0 U"


def _number(value: float, u: float | None) -> str:
    """Return a number with four digits of its uncertainty, so that small changes are visible."""
    if not u:
        return f"{value:.6g}"
    decimals = 3 - floor(log10(u))
    return f"{value:.{decimals}f}" if 0 <= decimals <= _MOST_DECIMALS else f"{value:.6g}"
