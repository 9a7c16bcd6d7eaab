"""The time of a call does not include that for which others had the processor."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rigrunner_testing import own_time
from rigrunner_testing.own_time import BUSY, OwnTime, measured

COMPUTES_S = 0.03


def compute():
    end_s = time.thread_time() + COMPUTES_S
    while time.thread_time() < end_s:
        pass


@pytest.fixture
def loaded_processor():
    """Restrict this process and three others that never wait to the same processor."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(before)})
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(3)]
    yield
    for loop in loops:
        loop.kill()
        loop.wait()
    os.sched_setaffinity(0, before)


@pytest.mark.skipif(sys.platform != "linux", reason="Linux counts the delays")
def test_time_of_others_does_not_count(loaded_processor):  # noqa: ARG001  (its load does it)
    own_s, all_s = [], []
    for _ in range(10):  # in one of them at least nothing else interferes
        began_s = time.monotonic()
        own_s.append(measured(compute))
        all_s.append(time.monotonic() - began_s)
    assert min(own.took_s for own in own_s) < 0.7 * min(all_s)
    assert min(own.waited_s for own in own_s) < COMPUTES_S / 2


def test_waiting_counts():
    own = measured(lambda: time.sleep(COMPUTES_S))
    assert own.took_s >= own.waited_s > 0.5 * COMPUTES_S


def test_computing_is_no_waiting_where_the_system_counts_no_delays(monkeypatch):
    monkeypatch.setattr(own_time, "Path", lambda _path: Path("no such file"))
    monkeypatch.setattr(own_time.time, "monotonic", iter([0.0, 5.0]).__next__)
    monkeypatch.setattr(own_time.time, "thread_time", iter([0.0, 1.0]).__next__)
    assert measured(lambda: None) == OwnTime(5.0, 5.0 - (1 + BUSY))
