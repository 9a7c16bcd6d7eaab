"""What was recorded and measured and has no limits: recordings as curves, tables as they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner_reports.plots.recordings import recorded_curves, table_curves
from rigrunner_reports.section import Section
from rigrunner_reports.view.limits import MeasuredTable, measured_table

if TYPE_CHECKING:
    from rigrunner.api.results import ReportInput
    from rigrunner_reports.plots.canvas import Plot

MOST_RECORDINGS = 6
"""So many recordings are drawn; of more, the first ones."""


@dataclass(frozen=True)
class RecordedTable:
    """A table without limits, with its figure."""

    table: MeasuredTable
    plot: Plot | None


@dataclass(frozen=True)
class RecordedView:
    """All that was recorded."""

    tables: tuple[RecordedTable, ...]
    plots: tuple[Plot, ...]
    recordings: int
    drawn: int


def recorded_view(report: ReportInput) -> RecordedView | None:
    """Return what no other section shows; None of a run whose torque is analysed."""
    result = report.result
    run = result.run
    if result.loaded:
        return None
    names = dict.fromkeys(row.name for row in run.measurements)
    limited = {row.name for row in run.measurements if row.limits}
    tables = []
    for name in names:
        rows = [row for row in run.measurements if row.name == name]
        if name not in limited:
            tables.append(RecordedTable(measured_table(name, rows), table_curves(rows)))
    plots = [recorded_curves(each) for each in run.recordings[:MOST_RECORDINGS]]
    if not (tables or plots):
        return None
    return RecordedView(tuple(tables), tuple(plots), len(run.recordings), len(plots))


SECTION = Section("recorded", "Recorded", 15, lambda report, _: recorded_view(report))
