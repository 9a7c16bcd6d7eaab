"""Time and cycles that had elapsed since the run began `main`, from the events."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime
from typing import TYPE_CHECKING

from rigrunner.api.events import StepStarted

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.data import Recording
    from rigrunner.api.events import Event


def seconds_since(began: datetime | None, utc: str) -> float | None:
    """Return the seconds since `began`; None if the time is earlier, or unknown."""
    time = moment(utc)
    if began is None or time is None or time < began:
        return None
    return (time - began).total_seconds()


def cycles_of(started: StepStarted | None, names: Iterable[str]) -> int | None:
    """Return the number of cycles before a step: of the role of these channels, or the only one."""
    counts = started.cycles if started is not None else {}
    roles = {name.partition(".")[0] for name in names} & counts.keys()
    # The channels of a row may be of a role that does not move, or of several.
    if len(roles) != 1:
        roles = set(counts)
    return round(counts[roles.pop()]) if len(roles) == 1 else None


def cycles_by_recording(events: Iterable[Event]) -> dict[str, int]:
    """Return the number of cycles before each recording, for those with cyclic motion."""
    counts = {
        event.recording: cycles_of(event, event.units)
        for event in events
        if isinstance(event, StepStarted) and event.recording
    }
    return {name: count for name, count in counts.items() if count is not None}


def with_elapsed(
    recordings: Iterable[Recording], events: Iterable[Event], began: datetime | None
) -> tuple[Recording, ...]:
    """Return recordings with the time and the cycles that had elapsed when each began."""
    cycles = cycles_by_recording(events)
    return tuple(
        replace(r, elapsed_s=seconds_since(began, r.started_utc), cycles=cycles.get(r.name))
        for r in recordings
    )


def moment(utc: str) -> datetime | None:
    """Return a time of day as it is stored; None for a text that is none."""
    try:
        return datetime.fromisoformat(utc)
    except ValueError:  # of a recording whose start was not found, or an event of a test
        return None
