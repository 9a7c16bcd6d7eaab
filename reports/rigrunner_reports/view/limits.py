"""The limits on measured values, with their decisions, ready to print."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.coordinates import coordinates_text, written_text
from rigrunner.api.summaries import table_cells
from rigrunner.api.verdict import worst
from rigrunner_reports.section import Section
from rigrunner_reports.view.decision import VerdictView, shown_verdict

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import Measurement
    from rigrunner.api.results import JudgedValue, MeasuredLimits

MOST_ROWS = 200
"""The most rows of a table; `rigrunner show` and the run file have all."""


@dataclass(frozen=True)
class LimitRow:
    """One measured value with its limit."""

    where: str
    setpoints: str
    of: str
    value: str
    limit: str
    verdict: VerdictView
    marginal: bool


@dataclass(frozen=True)
class MeasuredTable:
    """A table of measured values: its columns, and its rows with verdicts."""

    name: str
    columns: tuple[str, ...]
    rows: tuple[tuple[tuple[str, ...], VerdictView | None], ...]
    left_out: int


@dataclass(frozen=True)
class LimitsView:
    """All limits on measured values."""

    verdict: VerdictView
    reason: str
    rows: tuple[LimitRow, ...]
    left_out: int
    tables: tuple[MeasuredTable, ...]


def limits_view(limits: MeasuredLimits, measured: Sequence[Measurement]) -> LimitsView | None:
    """Return the limits with the tables of their values; None if there are none.

    Of very many values those out of limits are shown first.
    """
    if limits.verdict is None:
        return None
    values = limits.values
    if len(values) > MOST_ROWS:
        values = tuple(sorted(values, key=lambda value: value.passes))
    return LimitsView(
        verdict=shown_verdict(limits.verdict),
        reason=limits.reason,
        rows=tuple(map(_limit_row, values[:MOST_ROWS])),
        left_out=max(0, len(values) - MOST_ROWS),
        tables=tuple(
            measured_table(name, [row for row in measured if row.name == name])
            for name in dict.fromkeys(row.name for row in measured if row.limits or row.expected)
        ),
    )


def _limit_row(judged: JudgedValue) -> LimitRow:
    row, decision = judged.row, judged.decision
    return LimitRow(
        where=f"{row.name} {judged.number}",
        setpoints=", ".join(_where(row)),
        of=decision.of,
        value=judged.shown,
        limit=decision.limits.in_words,
        verdict=shown_verdict(decision.verdict),
        marginal=decision.marginal,
    )


def _where(row: Measurement) -> Iterator[str]:
    if row.coordinates:
        yield coordinates_text(row.coordinates, row.units, row.written_in)
    for name, value in row.setpoints.items():
        yield f"{name} {written_text(value, row.units.get(name, ''), row.written_in.get(name, ''))}"


def measured_table(name: str, rows: Sequence[Measurement]) -> MeasuredTable:
    """Return a table of measured values, ready to print."""
    shown = rows[:MOST_ROWS]
    heads, cells = table_cells(shown)
    printed = []
    for row, texts in zip(shown, cells, strict=True):
        verdict = worst(decision.verdict for decision in row.decisions)
        printed.append((tuple(texts), None if verdict is None else shown_verdict(verdict)))
    return MeasuredTable(name, tuple(heads), tuple(printed), len(rows) - len(shown))


SECTIONS = (
    Section(
        "measured",
        "Measured values",
        10,
        lambda report, _: limits_view(report.result.limits, report.result.run.measurements),
        unbroken=True,
    ),
)
