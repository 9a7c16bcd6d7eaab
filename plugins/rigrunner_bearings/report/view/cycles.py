"""The cycles that were rejected, each with the numbers that made it so."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING

from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.report.view.frequency_table import are_starts
from rigrunner_reports.numbers import fixed, plain, significant

if TYPE_CHECKING:
    from rigrunner.api import Rejection
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.api.torque import TorqueDetails

    _Judged = tuple[str, PeakPoint, str, Rejection]


MOST_ROWS = 200
"""Of the table: a run of hours can have thousands of rejected cycles."""


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
    """The rejections of a run and its no-load run, and how many cycles there were."""

    rows: tuple[RejectionRow, ...]
    left_out: int
    """How many more there were: those that were rejected by the least."""
    cycles: int
    spikes: int
    starts: bool = False
    """Whether what is called a cycle is a start from rest."""


def rejections(torque: TorqueDetails) -> RejectionTable:
    """Return the table of rejected cycles."""
    runs = named_runs(torque)
    points = [point for _, run in runs for point in run]
    judged: list[_Judged] = []
    for name, run in runs:
        for point in run:
            judged += [(name, point, "raw peak", rejection) for rejection in point.peak_rejections]
            shapes = point.waveform_rejections if isinstance(point, SwingPoint) else ()
            judged += [(name, point, "shape of the swing", rejection) for rejection in shapes]
    # Those that are farthest beyond their critical values, in their order.
    excess = [cycle.statistic / cycle.critical if cycle.critical else inf for *_, cycle in judged]
    places = sorted(range(len(judged)), key=excess.__getitem__, reverse=True)[:MOST_ROWS]
    shown = [judged[place] for place in sorted(places)]
    return RejectionTable(
        rows=tuple(
            RejectionRow(
                run=run,
                frequency=plain(point.set_frequency_hz),
                cycle=str(rejection.index),
                judged_by=judged_by,
                value=fixed(rejection.value, 4),
                rule=rejection.rule,
                statistic=significant(rejection.statistic),
                critical=significant(rejection.critical),
            )
            for run, point, judged_by, rejection in shown
        ),
        left_out=len(judged) - len(shown),
        cycles=sum(point.cycles for point in points),
        spikes=sum(point.spikes for point in points),
        starts=are_starts(torque),
    )


def named_runs(torque: TorqueDetails) -> list[tuple[str, tuple[PeakPoint, ...]]]:
    """Return the points of this run and, if it has one, of its no-load run, with their names."""
    runs = [("This run", torque.loaded), ("No-load run", torque.no_load)]
    return [(name, points) for name, points in runs if points]
