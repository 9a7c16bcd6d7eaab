"""When something was done, since the run began with `main`: told from the events."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime
from typing import TYPE_CHECKING

from rigrunner.api.events import StepStarted

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.data import Recording
    from rigrunner.api.events import Event

_MAIN = "main"


def main_began(events: Iterable[Event]) -> datetime | None:
    """Return when the first step of `main` began; None where none did.

    By the date and time: it goes on while a run is interrupted, and over a restart.
    """
    for event in events:
        if isinstance(event, StepStarted) and event.step.startswith(_MAIN):
            return _moment(event.utc)
    return None


def seconds_since(began: datetime | None, utc: str) -> float | None:
    """Return how many seconds later than `began` it was; None where that is before, or unknown."""
    moment = _moment(utc)
    if began is None or moment is None or moment < began:
        return None
    return (moment - began).total_seconds()


def with_elapsed(recordings: Iterable[Recording], events: Iterable[Event]) -> tuple[Recording, ...]:
    """Return recordings with the time that had elapsed when each was begun."""
    began = main_began(events)
    return tuple(
        replace(each, elapsed_s=seconds_since(began, each.started_utc)) for each in recordings
    )


def _moment(utc: str) -> datetime | None:
    try:
        return datetime.fromisoformat(utc)
    except ValueError:  # of a recording whose start was not found, or an event of a test
        return None
