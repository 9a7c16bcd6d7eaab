"""Which of several good attempts at one step counts: the last one; the others are kept beside."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.events import StepEnded

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.events import Event


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


def last_measured(events: Iterable[Event]) -> list[StepEnded]:
    """Return the end of each `measure` step that did not fail, the last one of each, in order."""
    latest: dict[tuple[str, int], StepEnded] = {}
    for event in events:
        if isinstance(event, StepEnded) and event.ok and event.measurement:
            step = (event.step, event.index)
            latest.pop(step, None)
            latest[step] = event
    return list(latest.values())
