"""Recordings and measured values without limits, as curves and tables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner_reports.section import Section
from rigrunner_reports.view.limits import MeasuredTable, measured_table

if TYPE_CHECKING:
    from rigrunner.api import Measurement, Recording, ReportInput
    from rigrunner.api.results import Result

MOST_RECORDINGS = 6
"""Of more recordings only the first ones are drawn."""


@dataclass(frozen=True)
class RecordedView:
    """The content of the section."""

    tables: tuple[MeasuredTable, ...]
    recordings: int
    drawn: int


def recorded_view(report: ReportInput) -> RecordedView | None:
    """Return what no other section shows, or None."""
    tables = unlimited_tables(report.result)
    drawn = len(drawn_recordings(report.result))
    count = len(report.result.run.recordings) if drawn else 0
    if not (tables or count):
        return None
    return RecordedView(
        tuple(measured_table(name, rows) for name, rows in tables.items()),
        count,
        drawn,
    )


def unlimited_tables(result: Result) -> dict[str, list[Measurement]]:
    """Return the rows of tables without limits; none if an analysis shows the recordings."""
    if any(details.shows_recordings for details in result.details):
        return {}
    tables: dict[str, list[Measurement]] = {}
    for row in result.run.measurements:
        tables.setdefault(row.name, []).append(row)
    return {
        name: rows
        for name, rows in tables.items()
        if not any(row.limits or row.expected for row in rows)
    }


def drawn_recordings(result: Result) -> tuple[Recording, ...]:
    """Return the recordings to draw; none if an analysis shows them."""
    if any(details.shows_recordings for details in result.details):
        return ()
    return result.run.recordings[:MOST_RECORDINGS]


SECTIONS = (Section("recorded", "Recorded", 15, lambda report, _: recorded_view(report)),)
