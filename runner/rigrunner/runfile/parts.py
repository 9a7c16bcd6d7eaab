"""The parts of an interrupted and resumed run, from its events."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rigrunner.api.data import ZeroReading
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


@dataclass(eq=False)
class Zeros:
    """The zero readings in force, as the events of a run come: in SI units, by channel."""

    in_force: dict[str, ZeroReading] = field(default_factory=dict)
    """Kept by what was measured meanwhile; a channel that is zeroed only later is added to it."""
    _earlier: list[dict[str, ZeroReading]] = field(default_factory=list)

    def take(self, event: Event) -> None:
        """Take an event; after a zero another mapping is in force."""
        if not (isinstance(event, StepEnded) and event.ok and event.action == "zero"):
            return
        previous = self.in_force
        self._earlier.append(previous)
        read = {
            name: ZeroReading(
                value,
                previous[name].number + 1 if name in previous else 1,
                *event.scatter.get(name, ()),
            )
            for name, value in event.values.items()
        }
        self.in_force = {**previous, **read}
        new = {name: zero for name, zero in read.items() if name not in previous}
        # What was measured before any zero of a channel has the first one.
        for earlier in self._earlier if new else ():
            earlier.update(new)


def zeros_in_force(events: Iterable[Event]) -> dict[str, dict[str, ZeroReading]]:
    """Return the zero readings in force during each finished recording.

    In SI units, by recording and channel. A resumed run is zeroed again; earlier recordings keep
    the earlier zero.
    """
    zeros = Zeros()
    in_force: dict[str, dict[str, ZeroReading]] = {}
    for event in events:
        zeros.take(event)
        if isinstance(event, StepEnded) and event.ok and event.recording and event.action != "zero":
            in_force[event.recording] = zeros.in_force
    return in_force


def zero_counts(events: Iterable[Event]) -> dict[str, int]:
    """Return the number of zero readings by channel."""
    zeros = Zeros()
    for event in events:
        zeros.take(event)
    return {name: zero.number for name, zero in zeros.in_force.items()}


def parts_of(events: Iterable[Event]) -> dict[str, int]:
    """Return the part of the run in which each recording was made; 1 up to a resumption."""
    part = 1
    parts: dict[str, int] = {}
    for event in events:
        if isinstance(event, Intervention) and event.action == RESUME_RUN:
            part += 1
        elif isinstance(event, StepStarted) and event.recording:
            parts[event.recording] = part
    return parts


def end_of(events: Iterable[Event]) -> RunEnded | None:
    """Return how the latest part of a run ended; None if it did not, or was interrupted."""
    end: RunEnded | None = None
    for event in events:
        if isinstance(event, RunEnded):
            end = event
        elif isinstance(event, RunStarted):
            end = None
    return end
