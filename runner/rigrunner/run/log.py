"""The text log of a run: what happened and when, one line each."""

from __future__ import annotations

import traceback
from contextlib import suppress
from typing import TYPE_CHECKING, Self

from rigrunner.api.events import (
    Alarm,
    Answer,
    Event,
    InterlockTripped,
    Intervention,
    LimitMissed,
    MadeSafe,
    Note,
    Prompt,
    RunEnded,
    RunStarted,
    Scanned,
    StepEnded,
    StepStarted,
)
from rigrunner.api.quantity import legible
from rigrunner.printable import printable

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

_CONTINUATION = "\n    "
"""Indents further lines of a text: an answer must not look like another event."""


class RunLog:
    """An event sink that writes `run.log` line by line."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("ab", buffering=0)
        self._write = self._file.write

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(OSError):  # a network disk may say now what it did not write
            self._file.close()

    def __call__(self, event: Event) -> None:
        """Write the event as a line; samples, rows and successful steps are left out."""
        if type(event) is Scanned:  # there may be thousands in a second
            return
        if text := event_text(event):
            line = printable(text).replace("\n", _CONTINUATION)
            self._write(f"{event.utc} {line}\n".encode())

    def trace(self, error: BaseException) -> None:
        """Write the traceback of an error below the line of its event."""
        text = printable("".join(traceback.format_exception(error)).rstrip())
        self._write(f"    {text}".replace("\n", _CONTINUATION).encode() + b"\n")


def event_text(event: Event) -> str:  # noqa: C901, PLR0911, PLR0912  (a line for each kind)
    """Return an event as text; '' for one that is not shown."""
    match event:
        case StepStarted():
            return f"{event.step}: {event.text}"
        case StepEnded():
            return "" if event.ok else f"{event.step}: failed"
        case RunStarted():
            steps = f"{event.steps} step{'' if event.steps == 1 else 's'}"
            return f"run {event.run_id} started: {steps}, {event.estimated_s:.0f} s"
        case Prompt():
            return f"{event.step}: asked: {event.text}"
        case Answer():
            return f"{event.step}: answered '{event.text}' ({event.by})"
        case InterlockTripped():
            within = f"detected within {event.latency_s:.2g} s"
            return f"ALARM {event.source}: {event.text} ({within}); it does: {event.does}"
        case LimitMissed():
            return f"{event.step}: OUT OF LIMITS: {event.text}"
        case Note():
            return f"{event.step}: note: {event.text}"
        case Alarm():
            return f"ALARM {event.source}: {event.text}"
        case Intervention():
            reason = f"reason: {event.reason}" if event.subject and event.reason else event.reason
            details = "; ".join(text for text in (event.subject, reason) if text)
            return f"{event.action} by {event.by}{f': {details}' if details else ''}"
        case MadeSafe():
            return made_safe_text(event)
        case RunEnded():
            return f"run {event.outcome}{f': {event.reason}' if event.reason else ''}"
        case _:
            return ""


def made_safe_text(event: MadeSafe) -> str:
    """Return what was made safe, with the read-back."""
    if event.problems:
        return f"NOT SAFE {event.what}: {'; '.join(event.problems)}"
    read_back = with_units(event.read_back, event.units)
    return f"{event.what} is safe{f': read back {read_back}' if read_back else ''}"


def with_units(values: Mapping[str, float], units: Mapping[str, str]) -> str:
    """Return values in SI as text, 'tester.load 0 N'; without a unit where none is known."""
    return ", ".join(
        f"{name} {legible(value, units.get(name, ''))}" for name, value in values.items()
    )
