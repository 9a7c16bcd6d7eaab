"""Which of several good attempts at one step counts: the last one; the others are kept beside."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.data import Measurement
from rigrunner.api.events import Scanned, StepEnded, StepStarted

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rigrunner.api.events import Event

    _Step = tuple[str, int]


def superseded(events: Iterable[Event]) -> frozenset[str]:
    """Return the names of the recordings whose point was repeated with success."""
    replaced, latest = set[str](), dict[tuple[str, int], str]()
    for event in events:
        if isinstance(event, StepEnded) and event.ok and event.recording:
            step = (event.step, event.index)
            if step in latest:
                replaced.add(latest[step])
            latest[step] = event.recording
    return frozenset(replaced)


def last_measured(events: Iterable[Event]) -> tuple[Measurement, ...]:
    """Return what was measured, in order: of each step its last attempt that did not fail.

    Of a scan of which none was completed the points of the last one count: each of them was done.
    """
    latest: dict[_Step, list[Measurement]] = {}
    completed: set[_Step] = set()
    rows: list[Measurement] = []
    units: Mapping[str, str] = {}
    for event in events:
        match event:
            case Scanned():
                rows.append(_row(event, units))
            case StepStarted(step=path, index=index, action="scan"):
                step, rows, units = (path, index), [], event.units
                if step not in completed:
                    latest.pop(step, None)
                    latest[step] = rows
            case StepEnded(step=path, index=index, ok=True, measurement=table) if (
                table or event.action == "scan"
            ):
                step = (path, index)
                completed.add(step)
                latest.pop(step, None)
                latest[step] = [_row(event, event.units)] if table else rows
    return tuple(row for rows in latest.values() for row in rows)


def _row(event: StepEnded | Scanned, units: Mapping[str, str]) -> Measurement:
    members = (*event.setpoints, *event.values)
    known = {member: units[member] for member in members if member in units}
    return Measurement(event.measurement, event.utc, event.setpoints, event.values, known)
