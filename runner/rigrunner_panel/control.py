"""Control of a rig: one client at a time has it, the others watch."""

from __future__ import annotations

import hashlib
import threading
from collections import Counter
from typing import TYPE_CHECKING

from rigrunner.clock import utc_text
from rigrunner_panel.errors import PanelError, wrong_state
from rigrunner_panel.view.sections import Control as ControlView

if TYPE_CHECKING:
    from datetime import datetime

    from rigrunner_panel.view.board import Board


def short_name(client: str) -> str:
    """Return the public part of a client's id; with the whole id others could take its place."""
    return hashlib.sha256(client.encode()).hexdigest()[:8]


class Control:
    """Stores which client has control and which clients are connected; the board has the rest."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self._lock = threading.Lock()
        self._holder = ""
        """The full id of the client in control; it is not sent to screens."""
        self._connected: Counter[str] = Counter()

    def take(self, client: str, name: str, now: datetime, *, take_over: bool) -> ControlView | None:
        """Give control to a client; return the previous holder if it was another client.

        Raises PanelError if another client has control and `take_over` is not set.
        """
        with self._lock:
            before = self._view
            is_other = before is not None and self._holder != client
            if before is not None and is_other and not take_over:
                message = f"{before.name} has control"
                raise wrong_state(message, "take it over, if that is agreed: it is recorded")
            since = before.since_utc if before is not None and not is_other else utc_text(now)
            self._holder = client
            view = ControlView(
                client=short_name(client),
                name=name,
                since_utc=since,
                connected=self._connected[client] > 0,
            )
            self._board.put(control=view)
            return before if is_other else None

    def release(self, client: str) -> None:
        """Release control; raise PanelError for a client that does not have it."""
        with self._lock:
            self._require(client)
            self._holder = ""
            self._board.put(control=None)

    def require(self, client: str) -> str:
        """Return the name of the client, which must have control; raise PanelError otherwise."""
        with self._lock:
            return self._require(client)

    def holds(self, client: str) -> str:
        """Return the name under which a client has control; '' if it does not have it."""
        with self._lock:
            view = self._view
            return view.name if view is not None and self._holder == client else ""

    def count_connection(self, client: str, step: int) -> None:
        """Count a client's WebSocket that was opened (1) or closed (-1)."""
        with self._lock:
            self._connected[client] += step
            # Adding nothing drops the clients whose count has come down to 0.
            self._connected += Counter()
            if (view := self._view) is not None:
                is_there = self._connected[self._holder] > 0
                self._board.put(control=view.model_copy(update={"connected": is_there}))
            self._board.put(watchers=self._connected.total())

    def is_connected(self, client: str) -> bool:
        """Return whether a client has an open WebSocket."""
        with self._lock:
            return self._connected[client] > 0

    @property
    def _view(self) -> ControlView | None:
        view: ControlView | None = self._board.get("control")
        return view

    def _require(self, client: str) -> str:
        view = self._view
        if view is None:
            message, hint = "nobody has control", "take it first: POST /api/v1/control"
            raise PanelError(403, "not_in_control", message, hint)
        if self._holder != client:
            message = f"{view.name} has control"
            raise PanelError(403, "not_in_control", message, "watch, or take it over")
        return view.name
