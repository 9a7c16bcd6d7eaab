"""Tracks who edits and who last saved each procedure, so that two editors see each other."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from rigrunner.clock import utc_text
from rigrunner.run.approval import approval_file
from rigrunner_panel.control import short_name
from rigrunner_panel.errors import PanelError
from rigrunner_panel.files import digest_of
from rigrunner_panel.view.editing import EditedView, EditorView

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from rigrunner_panel.files import ProcedureFiles

MOST = 200
GRACE_S = 10.0
"""Time in s for which a screen stays listed before it opens its WebSocket."""


@dataclass(frozen=True)
class Opened:
    """A screen and the procedure that it has open."""

    procedure: str
    by: str
    at: datetime


@dataclass(frozen=True)
class Saved:
    """A file as it was last saved at this panel."""

    digest: str
    by: str
    utc: str


class Editing:
    """Tracks the screens that edit, and notifies all of them. Thread-safe."""

    def __init__(
        self, publish: Callable[[tuple[EditedView, ...]], None], files: ProcedureFiles
    ) -> None:
        self._publish_views = publish
        self._files = files
        self._lock = threading.Lock()
        self._opened: dict[str, Opened] = {}
        self._saved: dict[str, Saved] = {}

    def open(self, client: str, procedure: str, by: str, now: datetime) -> None:
        """List a screen as editing a procedure, in place of the one that it edited before."""
        self._files.place(procedure)
        with self._lock:
            before = self._opened.pop(client, None)
            since = before.at if before is not None and before.procedure == procedure else now
            while len(self._opened) >= MOST:
                self._opened.pop(next(iter(self._opened)))
            self._opened[client] = Opened(procedure, by, since)
        self._publish()

    def leave(self, client: str) -> None:
        """Remove a screen from the list."""
        with self._lock:
            self._opened.pop(client, None)
        self._publish()

    def saved(self, procedure: str, digest: str, by: str, now: datetime) -> None:
        """Store who saved a file."""
        with self._lock:
            self._saved[procedure] = Saved(digest, by, utc_text(now))
        self._publish()

    def last_change(self, procedure: str) -> Saved:
        """Return the last change of a file; one made by another program has no person."""
        return self._last_change(procedure, self._files.place(procedure))

    def _last_change(self, procedure: str, path: Path) -> Saved:
        digest, saved = digest_of(path), self._saved.get(procedure)
        if saved is not None and saved.digest == digest:
            return saved
        return Saved(digest, "", _changed_utc(path))

    def tick(self, is_connected: Callable[[str], bool], now: datetime) -> None:
        """Remove closed screens, and check whether files were changed."""
        with self._lock:
            for client, opened in list(self._opened.items()):
                late = (now - opened.at).total_seconds() > GRACE_S
                if late and not is_connected(client):
                    del self._opened[client]
        self._publish()

    def _publish(self) -> None:
        with self._lock:
            views: dict[str, list[EditorView]] = {}
            for client, opened in self._opened.items():
                since = utc_text(opened.at)
                view = EditorView(client=short_name(client), name=opened.by, since_utc=since)
                views.setdefault(opened.procedure, []).append(view)
            self._publish_views(tuple(self._view(name, views[name]) for name in sorted(views)))

    def _view(self, procedure: str, editors: list[EditorView]) -> EditedView:
        try:
            path = self._files.place(procedure)
            last = self._last_change(procedure, path)
            approved_utc = _changed_utc(approval_file(path))
        except PanelError:  # it was removed, or is no longer marked as a procedure
            last, approved_utc = Saved("", "", ""), ""
        return EditedView(
            procedure=procedure,
            digest=last.digest,
            changed_utc=last.utc,
            changed_by=last.by,
            approved_utc=approved_utc,
            editors=tuple(editors),
        )


def _changed_utc(path: Path) -> str:
    try:
        return utc_text(datetime.fromtimestamp(path.stat().st_mtime, UTC))
    except OSError:
        return ""
