"""What a run sends to its guardian, and when it starts another one; without a process."""

from __future__ import annotations

import json
import os
from contextlib import contextmanager

import pytest

from e2e.helpers_supply import GUARDED, SupplyLab
from rigrunner.registry import load_registry
from rigrunner.run.guardian import guarding
from rigrunner.run.lab_plugins import with_lab_plugins
from rigrunner.station import parse_station
from rigrunner.tools.by_hand.station import ready_station

OVEN = "  oven: {type: supply, plugin: supply, settings: {file: oven.json, serial: '2'}}\n"
TWO = ("instruments:\n", f"{OVEN}instruments:\n")


class FakeProcess:
    """A guardian that only keeps the lines that it gets."""

    pid = 4712

    def __init__(self, words, *, pass_fds, **_):
        self.words, self.passed = words, pass_fds
        self.reads, writes = os.pipe()
        self.stdin = os.fdopen(writes, "wb", buffering=0)
        self.code = None

    def poll(self):
        return self.code

    def wait(self, _timeout_s=None):
        return 0

    def lines(self):
        with os.fdopen(self.reads, "rb") as pipe:
            return pipe.read().decode().splitlines()


@pytest.fixture
def started(monkeypatch, tmp_path):
    """Return the guardians that were started."""
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))
    processes = []

    def start(*words, **options):
        processes.append(FakeProcess(*words, **options))
        return processes[-1]

    monkeypatch.setattr(guarding.subprocess, "Popen", start)
    return processes


@contextmanager
def held_rig(tmp_path, *replacements):
    lab = SupplyLab(tmp_path / "lab", "bench")
    station = lab.add_station("guarded.yaml", "bench", GUARDED, *replacements)
    with ready_station(station).hold("jog psu") as ready:
        yield ready


def test_guardian_receives_task_and_release_of_rig(tmp_path, started):
    with held_rig(tmp_path, TWO) as ready:
        locks, roles = dict(ready.marks.locks), set(ready.marks.roles)
        with ready.guarded("jog psu", {"psu"}):
            owner = ready.marks.owner
    assert roles == {"psu", "oven"}
    assert owner.guardian == "a second process"
    (guardian,) = started
    assert guardian.words[-1] == "rigrunner.run.guardian.main"
    first, *beats = guardian.lines()
    task = json.loads(first)
    assert task["roles"] == ["psu"]
    assert task["unreachable"] == []
    assert task["process"] == os.getpid()
    assert task["locks"] == [str(lock) for lock in locks]
    assert task["handed"] == guardian.passed == list(locks.values())
    assert beats[-1] == "end"


def test_guardian_of_whole_rig_has_every_device(tmp_path, started):
    with held_rig(tmp_path, TWO) as ready, ready.guarded("jog psu", None):
        pass
    (guardian,) = started
    assert json.loads(guardian.lines()[0])["roles"] == ["oven", "psu"]


@pytest.mark.parametrize(("answer_s", "limit_s"), [(1, 10.0), (5, 15.0)])
def test_silence_limit_is_three_answers_and_at_least_ten_seconds(
    tmp_path, started, answer_s, limit_s
):
    with (
        held_rig(tmp_path, ("answer: 1 s", f"answer: {answer_s} s")) as ready,
        ready.guarded("jog psu", None),
    ):
        pass
    task = json.loads(started[0].lines()[0])
    assert (task["limit_s"], task["hangs"]) == (limit_s, True)


def test_lock_that_cannot_be_inherited_is_taken_by_path(tmp_path, started):
    with held_rig(tmp_path) as ready:
        before = dict(ready.marks.locks)
        ready.marks.locks = dict.fromkeys(before, -1)
        with ready.guarded("jog psu", None):
            pass
        ready.marks.locks = before
    task = json.loads(started[0].lines()[0])
    assert task["handed"] == started[0].passed == []
    assert task["locks"] == [str(path) for path in before]


def test_device_that_cannot_be_reopened_is_not_guarded(tmp_path, started, monkeypatch):
    with held_rig(tmp_path, TWO) as ready:
        monkeypatch.setattr(guarding, "not_reopenable", lambda *_: ["oven"])
        with ready.guarded("jog psu", None):
            assert ready.marks.owner.unguarded == "no second process can open oven"
    task = json.loads(started[0].lines()[0])
    assert (task["roles"], task["unreachable"]) == (["psu"], ["oven"])


def test_beat_tells_the_guardian_how_long_to_wait(tmp_path, started):
    with held_rig(tmp_path) as ready, ready.guarded("jog psu", None) as guardian:
        guardian._beat(123.25)
        child, guardian._child = guardian._child, None
        guardian._beat(99.0)  # between two guardians: nobody can be told
        guardian._child = child
    assert "123.250" in started[0].lines()


@pytest.mark.parametrize(("replacements", "is_guarded"), [((), False), ((GUARDED,), True)])
def test_run_without_guardian_has_a_remark(tmp_path, replacements, is_guarded):
    path = SupplyLab(tmp_path, "bench").add_station("s.yaml", "bench", *replacements)
    station = parse_station(path.read_text(encoding="utf-8"), str(path))
    registry = with_lab_plugins(load_registry(), station, path.parent)
    remarks = guarding.unguarded(station, registry, ["psu"])
    assert [(each.action, each.by) for each in remarks] == [("guardian", "station")][is_guarded:]
    assert all("there is no guardian" in each.subject for each in remarks)
    assert guarding.unguarded(station, registry, []) == []  # all is simulated


def test_guardian_is_replaced_three_times_and_each_loss_reported(tmp_path, started):
    with held_rig(tmp_path) as ready:
        with ready.guarded("jog psu", None) as guardian:
            for pid in range(4):
                guardian._replace(pid, -9)
        texts = [message.text for message in ready.messages.taken()]
    assert len(started) == 4
    assert texts[:3] == [
        f"the guardian (process {pid}) ended with code -9; process 4712 guards the rig now"
        for pid in range(3)
    ]
    assert texts[3].startswith(
        "the guardian (process 3) ended with code -9; no other one is started"
    )
    assert len(texts) == 4
    assert [guardian.stdin.closed for guardian in started] == [True] * 4
    assert ["end" in guardian.lines() for guardian in started] == [False] * 4


def test_run_continues_if_guardian_cannot_be_started(tmp_path, started, monkeypatch):
    def fail(*_, **__):
        raise OSError("out of memory")

    monkeypatch.setattr(guarding.subprocess, "Popen", fail)
    with held_rig(tmp_path) as ready:
        with ready.guarded("jog psu", None):
            assert not ready.marks.owner.guardian
        texts = [message.text for message in ready.messages.taken()]
    assert texts == ["no guardian could be started: out of memory"]
    assert started == []


def test_thread_of_guardian_is_daemon_and_ignored_by_debuggers(tmp_path, started):
    with held_rig(tmp_path) as ready, ready.guarded("jog psu", None) as guardian:
        thread = guardian._thread
        assert thread.daemon
        # the marks by which pydevd and debugpy leave a thread alone
        assert thread.pydev_do_not_trace is True
        assert thread.is_pydev_daemon_thread is True
        assert thread.is_alive()
    assert not thread.is_alive()
    started[0].lines()
