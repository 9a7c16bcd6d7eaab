"""The messages about a run to people who are away."""

from __future__ import annotations

import shutil
import time
from dataclasses import dataclass
from datetime import date
from typing import TYPE_CHECKING, Any

from rigrunner.api.events import (
    Alarm,
    Answer,
    Intervention,
    MadeSafe,
    Prompt,
    RunEnded,
    RunFinished,
    RunPlanned,
    RunStarted,
    StepEnded,
    StepStarted,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.api import Event
    from rigrunner_plugins.listeners.settings import RuleSettings, When

VERSION = 1
DISK_EVERY_S = 30.0
"""Time between two checks of the disk: no recording fills 5 GB, the usual limit, so soon."""
OF_LISTENERS = "event sink"
"""The source of an alarm that a listener failed: it is not reported by listeners."""
_TITLES: dict[When, str] = {
    "run_ended": "run ended",
    "waits_for_answer": "waits for an answer",
    "alarm": "ALARM",
    "disk_low": "disk low",
    "calibration_due": "calibration due",
}


@dataclass(frozen=True, kw_only=True)
class Message:
    """One message about a run."""

    kind: When
    utc: str
    station: str
    run: str
    procedure: str
    specimen: str
    text: str
    outcome: str = ""
    verdict: str = ""

    @property
    def title(self) -> str:
        """One line for a subject."""
        what = ", ".join(text for text in (self.outcome, self.verdict) if text)
        about = f" ({what})" if what else ""
        of = f" - {self.specimen}" if self.specimen else ""
        return " ".join(f"{self.station}: {_TITLES[self.kind]}{about}{of}".split())

    @property
    def body(self) -> str:
        """The same as lines, for people."""
        time_of_day = f"{self.utc[:10]} {self.utc[11:19]} UTC"
        facts = {"Procedure": self.procedure, "Run": self.run, "Time": time_of_day}
        return "\n".join([self.text, "", *(f"{key}: {value}" for key, value in facts.items())])

    def document(self) -> dict[str, Any]:
        """Return it as JSON values, for programs."""
        return {
            "version": VERSION,
            "kind": self.kind,
            "title": self.title,
            "text": self.text,
            "utc": self.utc,
            "station": self.station,
            "run": self.run,
            "procedure": self.procedure,
            "specimen": self.specimen,
            "outcome": self.outcome,
            "verdict": self.verdict,
        }


class Rules:
    """Finds in the events of one run what is to be reported.

    `waiting` is a message that is to be sent after a time, unless somebody answers before.
    """

    def __init__(
        self, settings: RuleSettings, monotonic: Callable[[], float] = time.monotonic
    ) -> None:
        self.waiting: Message | None = None
        self._settings = settings
        self._monotonic = monotonic
        self._run: RunPlanned | None = None
        self._run_id = ""
        self._ended: RunEnded | None = None
        self._disk_due_s = 0.0
        self._is_low = False

    def take(self, event: Event) -> Iterator[Message]:
        """Yield what is to be sent now."""
        match event:
            case RunPlanned():
                self._run, self._run_id = event, event.run_id
                yield from self._due(event)
            case RunStarted():
                self._run_id = event.run_id
            case Prompt():
                self._wait(event, f"The run waits for an answer: {event.text} ({event.step})")
            case Intervention(action="pause"):
                self._wait(event, f"The run is paused by {event.by}: {event.reason}")
            case Alarm() if event.source != OF_LISTENERS:
                yield from self._messages("alarm", event, f"{event.source}: {event.text}")
            case MadeSafe() if event.problems:
                text = f"{event.what} may not be safe: {'; '.join(event.problems)}"
                yield from self._messages("alarm", event, text)
            case Answer() | Intervention() | StepStarted() | StepEnded():
                self.waiting = None
            case RunEnded():
                self.waiting, self._ended = None, event
            case RunFinished():
                yield from self._end_message(event)
        yield from self._disk(event)

    def last(self) -> Iterator[Message]:
        """Yield the end of a run that sent RunEnded and no RunFinished."""
        if self._ended is not None:
            yield from self._end_message(self._ended)

    def _end_message(self, event: RunFinished | RunEnded) -> Iterator[Message]:
        self._ended = None
        text = f"The run ended: {event.outcome}{f', {event.reason}' if event.reason else ''}."
        verdict = getattr(event, "verdict", "")
        text += f" Verdict: {verdict}." if verdict else ""
        yield from self._messages("run_ended", event, text, str(event.outcome), verdict)

    def _wait(self, event: Event, text: str) -> None:
        self.waiting = next(self._messages("waits_for_answer", event, text), None)

    def _due(self, event: RunPlanned) -> Iterator[Message]:
        today = date.fromisoformat(event.utc[:10])
        left = {name: (date.fromisoformat(due) - today).days for name, due in event.due.items()}
        lines = [
            f"{name}: calibration {'is' if days >= 0 else 'was'} due on {event.due[name]}"
            for name, days in sorted(left.items(), key=lambda item: item[1])
            if days <= self._settings.calibration_due_days
        ]
        if lines:
            yield from self._messages("calibration_due", event, "\n".join(lines))

    def _disk(self, event: Event) -> Iterator[Message]:
        """Check the disk at intervals; low space is reported once, and again after a recovery."""
        now_s = self._monotonic()
        if self._run is None or now_s < self._disk_due_s:
            return
        self._disk_due_s = now_s + DISK_EVERY_S
        try:
            free_gb = shutil.disk_usage(self._run.folder).free / 1e9
        except OSError:
            return
        was_low, self._is_low = self._is_low, free_gb < self._settings.disk_low_gb
        if self._is_low and not was_low:
            least = f"{self._settings.disk_low_gb:g} GB"
            text = f"{free_gb:.1f} GB are free for runs, less than {least}"
            yield from self._messages("disk_low", event, text)

    def _messages(
        self, kind: When, event: Event, text: str, outcome: str = "", verdict: str = ""
    ) -> Iterator[Message]:
        if kind not in self._settings.on:
            return
        run = self._run
        yield Message(
            kind=kind,
            utc=event.utc,
            station=run.station if run else "",
            run=self._run_id,
            procedure=run.procedure if run else "",
            specimen=run.inputs.get("specimen", "") if run else "",
            text=text,
            outcome=outcome,
            verdict=verdict,
        )
