"""Passes the events of a run to the analyst, and what it finds to the screens."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from rigrunner.api.events import RunStarted, Samples, StepEnded, StepStarted
from rigrunner_panel.process.launch import Process
from rigrunner_panel.process.link import Sender
from rigrunner_panel.process.messages import (
    Analyse,
    Analysed,
    Ended,
    Failed,
    Follow,
    Watched,
    Watching,
)

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from rigrunner.api.data import Recording

ANALYST = "rigrunner_panel.live.analyst"
MOST_BLOCKS = 500
"""Most blocks that wait for a slow analyst; of more, the live analyses see a gap."""


class Watcher:
    """The analyst's process. Finished recordings are analysed one request at a time."""

    def __init__(self, runs: Path, station: Path, hear: Callable[[object], None]) -> None:
        self._runs = runs
        self._station = station
        self._hear = hear
        self._process = Process(ANALYST)
        self._sender = Sender(self._process.channel, MOST_BLOCKS)
        self._lock = threading.Lock()
        self._is_asked = self._is_fresh = False
        self._watched: Recording | None = None
        self._process.listen(self._take, lambda _: None)

    def notice(self, message: object) -> None:
        """Receive a message of the job."""
        match message:
            case RunStarted(run_id=name):
                self._sender.send(Follow(self._runs / name, self._station))
            case Watched():
                self._ask(message.recording)
            case StepEnded():
                self._sender(message)
                if message.recording or message.measurement or message.action == "scan":
                    self._ask(None)
            case StepStarted() | Samples():
                self._sender(message)
            case Watching():
                self._sender.send(message)
            case Ended() | Failed():
                self.close()

    def close(self) -> None:
        """Request no further analysis."""
        self._process.channel.close()
        self._sender.end()

    def _ask(self, watched: Recording | None) -> None:
        """Request an analysis, now or after the one that is being made."""
        with self._lock:
            self._is_fresh, self._watched = True, watched
            self._ask_next()

    def _ask_next(self) -> None:
        if self._is_fresh and not self._is_asked:
            self._is_asked, self._is_fresh = True, False
            self._sender.send(Analyse(self._watched))

    def _take(self, message: object) -> None:
        if isinstance(message, Analysed):
            with self._lock:
                self._is_asked = False
                self._ask_next()
        self._hear(message)
