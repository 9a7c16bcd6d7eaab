"""Repeats the analysis of the recordings so far, as fast as possible."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from rigrunner.api.events import RunStarted, Samples, StepEnded
from rigrunner_panel.process.launch import Process
from rigrunner_panel.process.messages import LIVE, Analyse, Analysed, Ended, Failed, Watched

if TYPE_CHECKING:
    from contextlib import AbstractContextManager
    from pathlib import Path

    from rigrunner.api.data import Recording
    from rigrunner_panel.live.story import Story

ANALYST = "rigrunner_panel.live.analyst"
LEAST_PAUSE_S = 0.25


def _finds_something(ended: StepEnded) -> bool:
    return bool(ended.recording or ended.measurement) or ended.action == "scan"


class Watcher:
    """Requests an analysis from the analyst's process when there is new data, one at a time."""

    def __init__(self, runs: Path, station: Path) -> None:
        self._runs = runs
        self._station = station
        self._process = Process(ANALYST)
        self._fresh = threading.Event()
        self._closed = threading.Event()
        self._folder: Path | None = None
        self._watched: Recording | None = None

    def start(self, story: Story, lock: AbstractContextManager[object]) -> None:
        """Start the thread; the lock is held while the state is updated."""
        work = threading.Thread(target=self._work, args=(story, lock), name="analyst", daemon=True)
        work.start()

    def notice(self, message: object) -> None:
        """Receive an event that may make another analysis worthwhile."""
        match message:
            case RunStarted(run_id=name):
                self._folder = self._runs / name
            case Watched():
                self._watched = message.recording
                self._fresh.set()
            case StepEnded() if _finds_something(message):
                self._watched = None
                self._fresh.set()
            case Samples(recording=name) if name not in {"", LIVE}:
                self._fresh.set()
            case Ended() | Failed():
                self.close()

    def close(self) -> None:
        """Request no further analysis."""
        self._closed.set()
        self._fresh.set()

    def _work(self, story: Story, lock: AbstractContextManager[object]) -> None:
        while self._fresh.wait() and not self._closed.is_set():
            self._fresh.clear()
            if self._folder is not None:
                self._ask(self._folder, story, lock)
            self._closed.wait(LEAST_PAUSE_S)
        self._process.close()

    def _ask(self, folder: Path, story: Story, lock: AbstractContextManager[object]) -> None:
        watched, self._watched = self._watched, None
        asked = Analyse(folder, self._station, story.recording, watched)
        found = self._process.ask(asked)
        if not isinstance(found, Analysed):
            self._closed.set()
            return
        with lock:
            story.analysed(found)
        if found.view is not None and found.view.taken_s > LEAST_PAUSE_S:
            self._closed.wait(found.view.taken_s / 2)  # two thirds of a core are enough
