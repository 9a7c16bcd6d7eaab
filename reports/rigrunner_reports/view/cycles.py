"""The cycles that were rejected, each with the numbers that made it so."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.analysis import SwingPoint
from rigrunner_reports.numbers import fixed, plain, significant
from rigrunner_reports.view.frequency_table import are_starts

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api.analysis import PeakPoint, Rejection
    from rigrunner.api.results import Result


@dataclass(frozen=True)
class RejectionRow:
    """One rejected cycle of one recording, judged by its peak or by its whole shape."""

    run: str
    frequency: str
    cycle: str
    judged_by: str
    value: str
    rule: str
    statistic: str
    critical: str


@dataclass(frozen=True)
class RejectionTable:
    """All rejections of a run and its no-load run, and how many cycles there were."""

    rows: tuple[RejectionRow, ...]
    cycles: int
    spikes: int
    starts: bool = False
    """Whether what is called a cycle is a start from rest."""


def rejections(result: Result) -> RejectionTable:
    """Return the table of rejected cycles."""
    runs = named_runs(result)
    points = [point for _, run in runs for point in run]
    return RejectionTable(
        rows=tuple(row for name, run in runs for point in run for row in _rows(name, point)),
        cycles=sum(point.cycles for point in points),
        spikes=sum(point.spikes for point in points),
        starts=are_starts(result),
    )


def named_runs(result: Result) -> list[tuple[str, tuple[PeakPoint, ...]]]:
    """Return the points of this run and, if it has one, of its no-load run, with their names."""
    runs = [("This run", result.loaded), ("No-load run", result.no_load)]
    return [(name, points) for name, points in runs if points]


def _rows(run: str, point: PeakPoint) -> Iterator[RejectionRow]:
    yield from _judged(run, point, "raw peak", point.peak_rejections)
    if isinstance(point, SwingPoint):
        yield from _judged(run, point, "shape of the swing", point.waveform_rejections)


def _judged(
    run: str, point: PeakPoint, judged_by: str, found: Sequence[Rejection]
) -> Iterator[RejectionRow]:
    for each in found:
        yield RejectionRow(
            run=run,
            frequency=plain(point.set_frequency_hz),
            cycle=str(each.index),
            judged_by=judged_by,
            value=fixed(each.value, 4),
            rule=each.rule,
            statistic=significant(each.statistic),
            critical=significant(each.critical),
        )
