"""The state that every screen shows: its sections and their changes, as messages."""

from __future__ import annotations

import json
import threading
from collections import deque
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import msgspec
from msgspec import structs

from rigrunner import __version__
from rigrunner.clock import utc_text
from rigrunner.run.log import event_text
from rigrunner_panel.view.queue import QueueView
from rigrunner_panel.view.sections import State

if TYPE_CHECKING:
    from collections.abc import Callable

    from pydantic import BaseModel

    from rigrunner.api.events import Event

SECTIONS = tuple(
    name
    for name in State.model_fields
    if name not in ("seq", "latest", "version", "you", "now_utc")
)

VERSION = 1
"""The version of the messages with events."""
MOST_EVENTS = 1000
"""The most events of a job that are kept for later requests; the run's file has all."""
_encode = msgspec.json.Encoder(
    enc_hook=lambda value: str(value) if isinstance(value, str) else dict(value)
).encode


class Board:
    """Sections by name. Any thread may put and read; each change is sent once, in order."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._sections: dict[str, Any] = dict.fromkeys(SECTIONS)
        self._sections |= {"phase": "idle", "watchers": 0, "readings": {}, "asked": ""}
        self._sections |= {"alarms": (), "queue": QueueView(), "channels": (), "editing": ()}
        self._texts: dict[str, str] = {}
        self._changed: set[str] = set()
        self._seq = 0
        self._events: deque[tuple[int, str]] = deque(maxlen=MOST_EVENTS)
        self._latest = self._sent = -1
        self.wake: Callable[[], None] = lambda: None
        """Called, in any thread, when something has changed."""

    def put(self, **sections: Any) -> None:
        """Change sections; what stays equal is no change."""
        with self._lock:
            changed = {name for name, value in sections.items() if self._sections[name] != value}
            self._sections |= sections
            self._changed |= changed
            for name in changed:
                self._texts.pop(name, None)
        if changed:
            self.wake()

    def get(self, name: str) -> Any:
        """Return a section."""
        with self._lock:
            return self._sections[name]

    def delta(self) -> str | None:
        """Return what has changed since the last delta, as a message; None if nothing has."""
        with self._lock:
            if not self._changed:
                return None
            self._seq += 1
            parts = (f'"{name}":{self._text(name)}' for name in SECTIONS if name in self._changed)
            changes = ",".join(parts)
            self._changed.clear()
            return f'{{"type":"delta","seq":{self._seq},"changes":{{{changes}}}}}'

    def add_event(self, event: Event) -> None:
        """Add an event of the run, which every screen gets unchanged."""
        sent = structs.replace(event, truth={}) if getattr(event, "truth", None) else event
        words = json.dumps(event_text(event))
        body = _encode(sent).decode()
        with self._lock:
            self._latest += 1
            text = f'{{"number":{self._latest},"text":{words},"event":{body}}}'
            self._events.append((self._latest, text))
        self.wake()

    def forget_events(self) -> None:
        """Forget the events of an earlier job; their numbers are not given again."""
        with self._lock:
            self._events.clear()

    def events(self, after: int) -> str:
        """Return the stored events after that number as JSON."""
        with self._lock:
            items = ",".join(text for number, text in self._events if number > after)
            return f'{{"version":{VERSION},"latest":{self._latest},"items":[{items}]}}'

    def new_events(self) -> list[str]:
        """Return messages of the events since the last time."""
        with self._lock:
            fresh = [text for number, text in self._events if number > self._sent]
            self._sent = self._latest
        return [f'{{"type":"event","version":{VERSION},{text[1:]}' for text in fresh]

    def state(self, you: str) -> str:
        """Return the whole state as JSON."""
        with self._lock:
            numbers = f'"seq":{self._seq},"latest":{self._latest}'
            head = f'{numbers},"version":{json.dumps(__version__)},"you":{json.dumps(you)}'
            head += f',"now_utc":"{utc_text(datetime.now(UTC))}"'
            parts = (f'"{name}":{self._text(name)}' for name in SECTIONS)
            return f"{{{head},{','.join(parts)}}}"

    def _text(self, name: str) -> str:
        if name not in self._texts:
            self._texts[name] = _json(self._sections[name])
        return self._texts[name]


def _json(
    value: BaseModel | tuple[BaseModel, ...] | dict[str, BaseModel] | str | float | None,
) -> str:
    if isinstance(value, tuple):
        return f"[{','.join(map(_json, value))}]"
    if isinstance(value, dict):
        members = (f"{json.dumps(name)}:{_json(section)}" for name, section in value.items())
        return f"{{{','.join(members)}}}"
    if value is None or isinstance(value, (str, int, float)):
        return json.dumps(value, allow_nan=False)
    return value.model_dump_json()
