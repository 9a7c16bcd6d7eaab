"""Progress of a run: a bar with the time left on a terminal, one line for each step elsewhere."""

from __future__ import annotations

import sys
from contextlib import contextmanager, nullcontext
from time import monotonic
from typing import TYPE_CHECKING, Protocol

from rigrunner.api.coordinates import coordinates_text
from rigrunner.api.events import (
    Alarm,
    Event,
    Intervention,
    LimitMissed,
    Note,
    Outcome,
    RunEnded,
    RunStarted,
    Scanned,
    StepStarted,
)
from rigrunner.cli.durations import steps_text
from rigrunner.cli.output import message
from rigrunner.printable import printable

if TYPE_CHECKING:
    from collections.abc import Iterator
    from contextlib import AbstractContextManager

    from rich.progress import Progress, TaskID

    from rigrunner.api.findings import Findings, MeasurementResult


_REDRAW_EVERY_S = 0.1
LIVE_DIGITS = 5
LINES = 10
"""Lines of progress of a part of the analysis, if there is no terminal for a bar."""


class ProgressSink(Protocol):
    """Shows the events of one or more runs."""

    def __call__(self, event: Event) -> None:
        """Show one event."""
        ...

    def analysing(self, what: str, done: int, of: int) -> None:
        """Show the progress of a part of the analysis."""
        ...

    def live(self, findings: Findings, *, is_whole: bool) -> None:
        """Show the live results of the analyses; `is_whole`: a recording is finished."""
        ...

    def paused(self) -> AbstractContextManager[None]:
        """Clear the terminal for a question, for as long as the context lasts."""
        ...


@contextmanager
def shown_progress() -> Iterator[ProgressSink]:
    """Yield the sink that suits stderr."""
    if not sys.stderr.isatty():
        yield LineProgress()
        return
    bar = BarProgress()
    with bar.shown():
        yield bar


class LineProgress:
    """Prints a line for each step, for logs and pipes."""

    def __init__(self) -> None:
        self._steps = 0
        self._shown: dict[tuple[str, str], int] = {}

    def __call__(self, event: Event) -> None:
        """Print a line where a step begins, and for alarms and notes."""
        match event:
            case RunStarted():
                self._steps = event.steps
                message(f"{event.run_id}: {steps_text(event.steps, event.estimated_s)}")
            case StepStarted():
                number = str(event.index + 1).rjust(len(str(self._steps)))
                where = coordinates_text(event.coordinates, event.units, event.written_in)
                place = f" ({where})" if where else ""
                message(f"[{number}/{self._steps}] {event.text}{place}")
            case _:
                _show_line(event)

    def analysing(self, what: str, done: int, of: int) -> None:
        """Print a line now and then."""
        if done * LINES // of > (done - 1) * LINES // of:
            message(f"{what}: {done} of {of}")

    def live(self, findings: Findings, *, is_whole: bool) -> None:
        """Print a line for each value that a finished recording changed."""
        for note in findings.notes:
            if (note, "") not in self._shown:
                self._shown[note, ""] = 0
                message(f"note: {note}")
        for result in findings.results if is_whole else ():
            if self._shown.get((result.name, result.place)) != result.readings:
                self._shown[result.name, result.place] = result.readings
                message(f"so far: {_live_text(result)}")

    def paused(self) -> AbstractContextManager[None]:
        """Do nothing: lines leave room for a question."""
        return nullcontext()


class BarProgress:
    """One bar for each run. Time is that of the run's clock, which may be simulated."""

    def __init__(self) -> None:
        self._progress = new_bar()
        self._task: TaskID | None = None
        self._analyses: dict[str, TaskID] = {}
        self._began_s = 0.0
        self._estimated_s = 0.0
        self._text = ""
        self._due_s = 0.0

    def shown(self) -> Progress:
        """Return the context in which the bar is shown."""
        return self._progress

    def analysing(self, what: str, done: int, of: int) -> None:
        """Update the bar of that part."""
        if what not in self._analyses:
            self._analyses[what] = self._progress.add_task(what, total=of, step=what)
        self._progress.update(self._analyses[what], completed=done)

    def live(self, findings: Findings, *, is_whole: bool) -> None:  # noqa: ARG002  (drawn again each time)
        """Show the latest value beside the step."""
        if self._task is not None and findings.results:
            text = printable(f"{self._text}: {_live_text(findings.results[-1])}")
            self._progress.update(self._task, step=text)

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Hide the bar while a person is asked."""
        self._progress.stop()
        try:
            yield
        finally:
            self._progress.start()

    def __call__(self, event: Event) -> None:
        """Update the bar to the event's time."""
        match event:
            case RunStarted():
                self._began_s, self._estimated_s = event.monotonic_s, event.estimated_s
                self._task = self._progress.add_task(event.run_id, total=event.estimated_s, step="")
            case RunEnded():
                completed = event.outcome is Outcome.COMPLETED
                end_s = self._began_s + self._estimated_s if completed else event.monotonic_s
                self._advance(end_s, f"{event.outcome}")
            case StepStarted():
                self._text = printable(event.text)
                self._advance(event.monotonic_s, self._text)
            case Scanned():
                # as often as the bar is drawn: there may be thousands of points per second
                if (now_s := monotonic()) >= self._due_s:
                    self._due_s = now_s + _REDRAW_EVERY_S
                    self._advance(event.monotonic_s, f"point {event.point + 1}: {self._text}")
            case Alarm() | Intervention() | Note():
                _show_line(event)
            case _:
                self._advance(event.monotonic_s)

    def _advance(self, monotonic_s: float, step: str | None = None) -> None:
        if self._task is None:
            return
        done_s = min(monotonic_s - self._began_s, self._estimated_s)
        if step is None:
            self._progress.update(self._task, completed=done_s)
        else:
            self._progress.update(self._task, completed=done_s, step=step)


def _live_text(result: MeasurementResult) -> str:
    """Return 'output voltage at load.current = 2 A: 12.014 V of 500 readings'."""
    at = f" at {result.place}" if result.place else ""
    value = f"{result.estimate.value:.{LIVE_DIGITS}g} {result.of.unit}"
    return f"{result.of.words}{at}: {value} of {result.readings} readings"


def _show_line(event: Event) -> None:
    match event:
        case LimitMissed():
            message(f"out of limits: {event.text}")
        case Note():
            message(f"note: {event.text}")
        case Alarm():
            message(f"alarm: {event.source}: {event.text}")
        case Intervention():
            parts = [text for text in (event.subject, event.reason) if text]
            message(": ".join((f"{event.action} by {event.by}", *parts)))


def new_bar() -> Progress:
    """Return bars with the fraction done, the time left, and a text."""
    from rich.console import Console  # noqa: PLC0415  (heavy, and needed on a terminal alone)
    from rich.progress import (  # noqa: PLC0415  (heavy, and for a terminal alone)
        BarColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.table import Column  # noqa: PLC0415  (heavy, and for a terminal alone)

    return Progress(
        TextColumn("{task.percentage:>3.0f} %"),
        BarColumn(bar_width=20),
        TimeRemainingColumn(),
        TextColumn("{task.fields[step]}", markup=False, table_column=Column(ratio=1, no_wrap=True)),
        console=Console(stderr=True),
        expand=True,  # otherwise a long text takes the space of the bar, not the remaining space
    )
