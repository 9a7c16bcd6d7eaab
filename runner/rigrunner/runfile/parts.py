"""The parts of an interrupted and resumed run, from its events."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.events import (
    RESUME_RUN,
    Intervention,
    RunEnded,
    RunStarted,
    StepEnded,
    StepStarted,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.events import Event


def zeros_in_force(events: Iterable[Event]) -> dict[str, dict[str, float]]:
    """Return the zero readings in force during each finished recording.

    In SI units, by recording and channel. A resumed run is zeroed again; earlier recordings keep
    the earlier zero.
    """
    latest: dict[str, float] = {}
    found: dict[str, dict[str, float]] = {}
    for event in events:
        if not isinstance(event, StepEnded) or not event.ok:
            continue
        if event.action == "zero":
            latest |= event.values
        elif event.recording:
            found[event.recording] = dict(latest)
    return found


def parts_of(events: Iterable[Event]) -> dict[str, int]:
    """Return the part of the run in which each recording was made; 1 up to a resumption."""
    part = 1
    found: dict[str, int] = {}
    for event in events:
        if isinstance(event, Intervention) and event.action == RESUME_RUN:
            part += 1
        elif isinstance(event, StepStarted) and event.recording:
            found[event.recording] = part
    return found


def end_of(events: Iterable[Event]) -> RunEnded | None:
    """Return how the latest part of a run ended; None if it did not, or was interrupted."""
    end: RunEnded | None = None
    for event in events:
        if isinstance(event, RunEnded):
            end = event
        elif isinstance(event, RunStarted):
            end = None
    return end
