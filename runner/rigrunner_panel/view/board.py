"""The state that every screen shows: sections, who changed, and how to tell it."""

from __future__ import annotations

import json
import threading
from typing import TYPE_CHECKING, Any

from rigrunner import __version__
from rigrunner_panel.view.queue import QueueView
from rigrunner_panel.view.sections import Readings, State

if TYPE_CHECKING:
    from collections.abc import Callable

    from pydantic import BaseModel

SECTIONS = tuple(name for name in State.model_fields if name not in ("seq", "version", "you"))


class Board:
    """Sections by name. Any thread may put and read; each change is told once, in order."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._sections: dict[str, Any] = dict.fromkeys(SECTIONS)
        self._sections |= {"phase": "idle", "watchers": 0, "readings": Readings(), "asked": ""}
        self._sections |= {"alarms": (), "log": (), "queue": QueueView(), "channels": ()}
        self._texts: dict[str, str] = {}
        self._changed: set[str] = set()
        self._seq = 0
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

    def state(self, you: str) -> str:
        """Return the whole state as JSON."""
        with self._lock:
            head = f'"seq":{self._seq},"version":{json.dumps(__version__)},"you":{json.dumps(you)}'
            parts = (f'"{name}":{self._text(name)}' for name in SECTIONS)
            return f"{{{head},{','.join(parts)}}}"

    def _text(self, name: str) -> str:
        if name not in self._texts:
            self._texts[name] = _json(self._sections[name])
        return self._texts[name]


def _json(value: BaseModel | tuple[BaseModel, ...] | str | float | None) -> str:
    if isinstance(value, tuple):
        return f"[{','.join(map(_json, value))}]"
    if value is None or isinstance(value, (str, int, float)):
        return json.dumps(value, allow_nan=False)
    return value.model_dump_json()
