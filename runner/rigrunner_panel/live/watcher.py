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

    def __init__(self, runs: Path, station: Path, receive: Callable[[object], None]) -> None:
        self._runs = runs
        self._station = station
        self._receive = receive
        self._process = Process(ANALYST)
        self._sender = Sender(self._process.channel, MOST_BLOCKS)
        self._lock = threading.Lock()
        self._is_busy = self._is_due = False
        """Whether an analysis is being made, and one of the finished recordings must follow."""
        self._watched: Recording | None = None
        """The next recording of a manual session to analyse, after that."""
        self._process.listen(self._take, lambda _: None)

    def notice(self, message: object) -> None:
        """Receive a message of the job."""
        match message:
            case RunStarted(run_id=name):
                self._sender.send(Follow(self._runs / name, self._station))
            case Watched(recording=recording):
                with self._lock:
                    self._watched = recording
                    self._request_next()
            case StepEnded():
                self._sender(message)
                if message.recording or message.measurement or message.action == "scan":
                    with self._lock:
                        self._is_due = True
                        self._request_next()
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

    def _request_next(self) -> None:
        """Request the next analysis, unless one is being made."""
        if self._is_busy or not (self._is_due or self._watched is not None):
            return
        self._is_busy = True
        if self._is_due:  # first: of watched channels there is always a newer recording
            self._is_due = False
            self._sender.send(Analyse(None))
        else:
            self._sender.send(Analyse(self._watched))
            self._watched = None

    def _take(self, message: object) -> None:
        if isinstance(message, Analysed):
            with self._lock:
                self._is_busy = False
                self._request_next()
        self._receive(message)
