"""Requests to the analyst: one analysis at a time, and none is lost."""

from __future__ import annotations

from queue import SimpleQueue

import numpy as np
import pytest

from rigrunner.api.data import Recording
from rigrunner.api.events import StepEnded
from rigrunner.bus import EventStamp
from rigrunner.clock import SimulatedClock
from rigrunner_panel.live import watcher as module
from rigrunner_panel.process.messages import Analyse, Analysed, Watched

WITHIN_S = 60


class Analyst:
    """A process that answers only on demand, and its channel."""

    def __init__(self, _module):
        self.channel = self
        self.requests = SimpleQueue()

    def listen(self, hear, _ended):
        self.answer = lambda: hear(Analysed(None))

    def send(self, message):
        if isinstance(message, Analyse):
            self.requests.put(message.watched)

    def close(self):
        """Nothing is open."""


@pytest.fixture
def watcher(monkeypatch, tmp_path):
    monkeypatch.setattr(module, "Process", Analyst)
    watcher = module.Watcher(tmp_path, tmp_path / "s.yaml", lambda _: None)
    yield watcher
    watcher.close()


def recording(name):
    return Recording(name, 100.0, "", {}, {"tester.torque": np.zeros(1)}, {"tester.torque": "N·m"})


def test_finished_recording_is_analysed_between_watched_channels(watcher):
    """The analyst is busy with the channels when a point is recorded, and more of them follow."""
    analyst, (first, second, third) = watcher._process, map(recording, "abc")
    ended = EventStamp(SimulatedClock())(
        StepEnded, step="hand", index=0, ok=True, action="record", recording="001_10Hz"
    )
    for message in (Watched(first), Watched(second), ended, Watched(third)):
        watcher.notice(message)
    requests = []
    for _ in range(3):
        requests.append(analyst.requests.get(timeout=WITHIN_S))
        analyst.answer()
    assert [request and request.name for request in requests] == ["a", None, "c"]
    assert analyst.requests.empty()
