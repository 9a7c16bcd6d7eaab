"""What the guardian takes for a hang, without waiting."""

from __future__ import annotations

import bdb
import io
import json
import os
import subprocess
import sys
import threading
from queue import SimpleQueue

import pytest

from e2e.helpers_supply import GUARDED, SupplyLab
from helpers_cli import call
from rigrunner.api.member import Member
from rigrunner.rig_state import DriveMark, Marker, Owner, record_made_safe
from rigrunner.rig_state.marker import encode
from rigrunner.run.guardian import acting, main
from rigrunner.run.guardian.guarding import debugger_at

TASK = {"what": "a run", "station": "s", "limit_s": 30.0, "hangs": True, "process": 7}

OWNER = Owner("s", "/lab/s.yaml", "STEPS", 7, "bench", "2026-03-01T12:00:00.000Z")


class FakeOwner:
    pid = 7
    handle = -1

    def __init__(self):
        self.is_dead = self.is_traced = False
        self.sent = []

    def send(self, name):
        self.sent.append(name)
        self.is_dead = name == "SIGKILL"


@pytest.fixture
def clock(monkeypatch):
    """Return the time, in a list, which only the test advances."""
    now = [0.0]
    monkeypatch.setattr(main.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(main, "_is_energised", lambda _task: True)
    return now


@pytest.fixture
def owner():
    return FakeOwner()


@pytest.fixture
def patience(clock, owner):  # noqa: ARG001  (its time stands still)
    return main._Patience(TASK, owner)


def ticks(patience, clock, count, seconds=1.0):
    for _ in range(count):
        clock[0] += seconds
        patience.tick()


def test_patience_ends_after_limit_and_restarts_with_each_beat(patience, clock):
    ticks(patience, clock, 30)
    assert not patience.is_over
    patience.beat(10.0)
    ticks(patience, clock, 10)
    assert not patience.is_over
    ticks(patience, clock, 1)
    assert patience.is_over


def test_suspended_computer_does_not_use_up_patience(patience, clock):
    ticks(patience, clock, 1, seconds=8 * 3600.0)
    assert not patience.is_over
    ticks(patience, clock, 28)  # one tick counts as two seconds at most
    assert not patience.is_over
    ticks(patience, clock, 1)
    assert patience.is_over


def test_hung_process_is_terminated_then_killed(patience, clock, owner, monkeypatch):
    lines = []
    monkeypatch.setattr(main, "say", lines.append)
    ticks(patience, clock, 31)
    patience.end()
    assert (owner.sent, patience.was_asked) == (["SIGTERM", "SIGCONT"], True)
    ticks(patience, clock, 11)
    assert patience.is_over
    patience.end()
    assert owner.sent[-1] == "SIGKILL"
    assert lines[-1].endswith("does not end: it is killed")


def test_unkillable_process_is_reported(patience, clock, monkeypatch):
    lines = []
    monkeypatch.setattr(main, "say", lines.append)
    monkeypatch.setattr(main, "_dies_within", lambda *_: False)
    patience.end()
    patience.end()
    assert "go to the rig and switch it off by hand" in lines[-1]
    ticks(patience, clock, 60)
    assert not patience.is_over


def test_process_making_progress_after_request_is_not_killed(patience, clock, owner):
    ticks(patience, clock, 31)
    patience.end()
    patience.beat(30.0)
    ticks(patience, clock, 29)
    assert not patience.is_over
    assert "SIGKILL" not in owner.sent


def test_process_released_by_its_debugger_has_its_full_time_again(patience, clock, owner):
    owner.is_traced = True
    ticks(patience, clock, 60)
    owner.is_traced = False
    ticks(patience, clock, 29)
    assert not patience.is_over


@pytest.mark.parametrize(
    ("status", "is_traced"),
    [
        ("Name:\tpython\nTracerPid:\t0\nUid:\t0\n", False),
        ("Name:\tpython\nTracerPid:\t4711\nUid:\t0\n", True),
        ("Name:\tpython\n", False),
        (None, False),  # another system
    ],
)
def test_debugger_is_known_from_the_status_of_the_process(tmp_path, monkeypatch, status, is_traced):
    """See proc_pid_status(5): the number of the tracing process, 0 for none."""
    if status is not None:
        (tmp_path / "status").write_text(status)
    monkeypatch.setattr(main, "Path", lambda _: tmp_path / "status")
    assert main.Owner(os.getpid()).is_traced is is_traced


@pytest.mark.parametrize("why", ["traced", "not energised"])
def test_debugged_process_and_unenergised_rig_are_left_alone(
    patience, clock, owner, why, monkeypatch
):
    owner.is_traced = why == "traced"
    monkeypatch.setattr(main, "_is_energised", lambda _task: why == "traced")
    ticks(patience, clock, 31)
    patience.end()
    assert owner.sent == []
    assert not patience.is_over


@pytest.mark.parametrize(
    ("messages", "reason"),
    [
        (["30.0", "end"], ""),
        (["30.0", "closed"], "the process of a run (7) died"),
        (["dead", "30.0", "end", "closed"], ""),
        (["dead", "30.0", "closed"], "the process of a run (7) died"),
    ],
)
def test_released_rig_is_left_alone_and_death_is_reported(owner, messages, reason):
    news = SimpleQueue()
    for message in messages:
        news.put(message)
    owner.is_dead = "end" not in messages or "dead" in messages
    assert main._guard(TASK, owner, news) == reason


@pytest.mark.parametrize("exists", [True, False])
def test_rig_without_lock_file_may_be_energised(tmp_path, monkeypatch, exists):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path))
    lock = tmp_path / "s.lock"
    if exists:
        lock.touch()
    assert main._is_energised({"station": "s", "locks": [str(lock)]}) is not exists


@pytest.mark.parametrize(("role", "expected"), [("psu", True), ("oven", False)])
def test_unreadable_marker_may_contain_any_drive(role, expected):
    drives = (DriveMark(Member("psu", "voltage"), "V", 0.0, 40.0),)
    assert acting._has_drive_of(Marker("s", OWNER, drives), role) is expected
    assert acting._has_drive_of(Marker("s", None), role)


def test_rig_made_safe_after_the_run_is_not_energised(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path))
    task = {"station": "s", "locks": [str(tmp_path / "s.lock")]}
    (tmp_path / "s.lock").touch()
    drives = (DriveMark(Member("psu", "voltage"), "V", 0.0, 40.0),)
    (tmp_path / "s.energised").write_bytes(encode(OWNER, drives))
    assert main._is_energised(task)
    record_made_safe("s", "somebody made it safe")
    assert not main._is_energised(task)


def test_guardian_with_closed_pipe_waits_for_death_of_owner(owner, monkeypatch):
    monkeypatch.setattr(main, "TICK_S", 0.01)
    monkeypatch.setattr(main, "_is_energised", lambda _task: True)
    news = SimpleQueue()
    news.put("closed")
    reasons = []
    thread = in_a_thread(lambda: reasons.append(main._guard({**TASK, "limit_s": 0.0}, owner, news)))
    thread.join(0.3)
    assert reasons == []
    assert owner.sent == []  # without beats, silence is not judged
    owner.is_dead = True
    thread.join(10)
    assert reasons == ["the process of a run (7) died"]


def test_silent_process_is_killed(owner, monkeypatch):
    for name in ("TICK_S", "GRACE_S"):
        monkeypatch.setattr(main, name, 0.01)
    monkeypatch.setattr(main, "_is_energised", lambda _task: True)
    monkeypatch.setattr(main, "say", lambda _text: None)
    reason = main._guard({**TASK, "limit_s": 0.05}, owner, SimpleQueue())
    assert reason == "the process of a run (7) hung, and was ended"
    assert owner.sent == ["SIGTERM", "SIGCONT", "SIGKILL"]


@pytest.mark.parametrize(("words", "acts"), [("end\n", False), ("30.0\n", True)])
def test_guardian_acts_for_dead_owner_unless_rig_was_released(monkeypatch, words, acts):
    with subprocess.Popen([sys.executable, "-c", ""]) as owner:
        pass
    stdin = io.StringIO(json.dumps({**TASK, "process": owner.pid}) + f"\n{words}")
    reasons = []
    monkeypatch.setattr(main, "IGNORED", ())
    monkeypatch.setattr(main.sys, "stdin", stdin)
    monkeypatch.setattr(acting, "act", lambda _task, reason: reasons.append(reason))
    assert main.main() == 0
    assert reasons == [f"the process of a run ({owner.pid}) died"] * acts


def test_guardian_without_task_does_nothing(monkeypatch):
    monkeypatch.setattr(main, "IGNORED", ())
    monkeypatch.setattr(main.sys, "stdin", io.StringIO())
    monkeypatch.setattr(acting, "act", lambda *_: pytest.fail("it acted"))
    assert main.main() == 0


@pytest.mark.parametrize(("needed_s", "returns"), [(10.0, True), (0.0, False)])
def test_attempt_has_time_for_its_drives(monkeypatch, needed_s, returns):
    release = threading.Event()

    def attempt(_task, need):
        need(needed_s)
        release.wait(0.2 if returns else 10)
        return (), ""

    monkeypatch.setattr(acting, "ATTEMPT_S", 0.02)
    monkeypatch.setattr(acting, "_one_attempt", attempt)
    problem = "" if returns else "a device did not return within 0.02 s"
    assert acting._limited_attempt({}) == ((), problem)
    release.set()


def in_a_thread(work):
    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    return thread


def test_python_debugger_is_detected_in_its_thread():
    locked, free = threading.Event(), threading.Event()

    class Debugger(bdb.Bdb):
        def user_line(self, frame):  # noqa: ARG002  (a debugger's)
            locked.set()
            free.wait(10)

    def debugged():
        Debugger().run("x = 1", {})

    thread = in_a_thread(debugged)
    assert locked.wait(10)
    assert debugger_at(thread)
    free.set()
    waiting = threading.Event()
    assert not debugger_at(in_a_thread(lambda: waiting.wait(10)))
    waiting.set()
    thread.join()


def test_waiting_guardian_imports_only_standard_library():
    script = "import rigrunner.run.guardian.main, sys; print(*sys.modules)"
    process = subprocess.run(
        [sys.executable, "-I", "-c", script], capture_output=True, text=True, check=True
    )
    top = {word.partition(".")[0] for word in process.stdout.split()}
    assert "rigrunner" in top
    assert not {"numpy", "pydantic", "yaml", "filelock", "pluggy", "click"} & top


def test_check_states_what_guardian_guards(tmp_path):
    lab = SupplyLab(tmp_path / "lab")
    words = ["check", lab.procedure, "--station", lab.station]
    assert "There is no guardian" in call(*words).out
    lab.add_station("station.yaml", lab.station_id, GUARDED)
    assert "A guardian makes the rig safe" in call(*words).out
    plugin = lab.folder / "plugins" / "supply.py"
    text = plugin.read_text(encoding="utf-8")
    plugin.write_text(
        text.replace("factory=Supply,", "factory=Supply, reopenable=False,"), encoding="utf-8"
    )
    assert "except psu: no second process can open it" in call(*words).out
