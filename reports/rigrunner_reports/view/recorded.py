"""What was recorded and measured and has no limits: recordings as curves, tables as they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.torque import TorqueDetails
from rigrunner_reports.section import Section
from rigrunner_reports.view.limits import MeasuredTable, measured_table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Measurement, ReportInput
    from rigrunner.api.results import Result

MOST_RECORDINGS = 6
"""So many recordings are drawn; of more, the first ones."""


@dataclass(frozen=True)
class RecordedView:
    """All that was recorded."""

    tables: tuple[MeasuredTable, ...]
    recordings: int
    drawn: int


def recorded_view(report: ReportInput) -> RecordedView | None:
    """Return what no other section shows; None of a run whose torque is analysed."""
    torque = TorqueDetails.of(report.result)
    tables = unlimited_tables(report.result)
    count = 0 if torque.loaded else len(report.result.run.recordings)
    if not (tables or count):
        return None
    return RecordedView(
        tuple(measured_table(name, rows) for name, rows in tables.items()),
        count,
        min(count, MOST_RECORDINGS),
    )


def unlimited_tables(result: Result) -> dict[str, list[Measurement]]:
    """Return the rows of each table of which no value has a limit; none beside analysed torque."""
    torque = TorqueDetails.of(result)
    if torque.loaded:
        return {}
    tables: dict[str, list[Measurement]] = {}
    for row in result.run.measurements:
        tables.setdefault(row.name, []).append(row)
    return {name: rows for name, rows in tables.items() if not _are_limited(rows)}


SECTIONS = (Section("recorded", "Recorded", 15, lambda report, _: recorded_view(report)),)


def _are_limited(rows: Sequence[Measurement]) -> bool:
    return any(row.limits or row.expected for row in rows)
