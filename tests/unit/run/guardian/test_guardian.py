"""What the guardian takes for a hang, without waiting for one."""

from __future__ import annotations

import bdb
import io
import json
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
    """Time that passes only where a test says so."""
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


def test_silence_is_over_after_the_limit_and_a_beat_begins_it_anew(patience, clock):
    ticks(patience, clock, 30)
    assert not patience.is_over
    patience.beat(10.0)
    ticks(patience, clock, 10)
    assert not patience.is_over
    ticks(patience, clock, 1)
    assert patience.is_over


def test_a_computer_that_was_suspended_has_missed_nothing(patience, clock):
    ticks(patience, clock, 1, seconds=8 * 3600.0)
    assert not patience.is_over
    ticks(patience, clock, 28)  # one look counts as two seconds at most
    assert not patience.is_over
    ticks(patience, clock, 1)
    assert patience.is_over


def test_a_hung_process_is_asked_and_then_killed(patience, clock, owner):
    ticks(patience, clock, 31)
    patience.end()
    assert (owner.sent, patience.was_asked) == (["SIGTERM", "SIGCONT"], True)
    ticks(patience, clock, 11)
    assert patience.is_over
    patience.end()
    assert owner.sent[-1] == "SIGKILL"


def test_a_process_that_not_even_a_kill_ends_is_told_to_a_person(patience, clock, monkeypatch):
    lines = []
    monkeypatch.setattr(main, "say", lines.append)
    monkeypatch.setattr(main, "_dies_within", lambda *_: False)
    patience.end()
    patience.end()
    assert "go to the rig and switch it off by hand" in lines[-1]
    ticks(patience, clock, 60)
    assert not patience.is_over


def test_a_process_that_makes_progress_after_it_was_asked_is_not_killed(patience, clock, owner):
    ticks(patience, clock, 31)
    patience.end()
    patience.beat(30.0)
    ticks(patience, clock, 29)
    assert not patience.is_over
    assert "SIGKILL" not in owner.sent


@pytest.mark.parametrize("why", ["traced", "not energised"])
def test_what_a_debugger_holds_and_what_is_not_energised_is_left_alone(
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
def test_a_rig_that_was_given_back_is_left_alone_and_a_death_is_told(owner, messages, reason):
    news = SimpleQueue()
    for message in messages:
        news.put(message)
    owner.is_dead = "end" not in messages or "dead" in messages
    assert main._guard(TASK, owner, news) == reason


@pytest.mark.parametrize("there", [True, False])
def test_a_rig_whose_lock_was_removed_may_be_energised(tmp_path, monkeypatch, there):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path))
    lock = tmp_path / "s.lock"
    if there:
        lock.touch()
    assert main._is_energised({"station": "s", "locks": [str(lock)]}) is not there


@pytest.mark.parametrize(("role", "left"), [("psu", True), ("oven", False)])
def test_each_drive_of_an_unreadable_marker_may_be_energised(role, left):
    drives = (DriveMark(Member("psu", "voltage"), "V", 0.0, 40.0),)
    assert acting._has_drive_of(Marker("s", OWNER, drives), role) is left
    assert acting._has_drive_of(Marker("s", None), role)


def test_a_drive_that_was_made_safe_after_the_run_is_not_energised(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path))
    task = {"station": "s", "locks": [str(tmp_path / "s.lock")]}
    (tmp_path / "s.lock").touch()
    drives = (DriveMark(Member("psu", "voltage"), "V", 0.0, 40.0),)
    (tmp_path / "s.energised").write_bytes(encode(OWNER, drives))
    assert main._is_energised(task)
    record_made_safe("s", "somebody made it safe")
    assert not main._is_energised(task)


def test_a_guardian_whose_pipe_was_closed_waits_for_the_death_of_its_owner(owner, monkeypatch):
    monkeypatch.setattr(main, "TICK_S", 0.01)
    monkeypatch.setattr(main, "_is_energised", lambda _task: True)
    news = SimpleQueue()
    news.put("closed")
    reasons = []
    waits = in_a_thread(lambda: reasons.append(main._guard({**TASK, "limit_s": 0.0}, owner, news)))
    waits.join(0.3)
    assert reasons == []
    assert owner.sent == []  # without beats it looks at no silence
    owner.is_dead = True
    waits.join(10)
    assert reasons == ["the process of a run (7) died"]


def test_the_silence_of_a_living_process_ends_it(owner, monkeypatch):
    for name in ("TICK_S", "GRACE_S"):
        monkeypatch.setattr(main, name, 0.01)
    monkeypatch.setattr(main, "_is_energised", lambda _task: True)
    monkeypatch.setattr(main, "say", lambda _text: None)
    reason = main._guard({**TASK, "limit_s": 0.05}, owner, SimpleQueue())
    assert reason == "the process of a run (7) hung, and was ended"
    assert owner.sent == ["SIGTERM", "SIGCONT", "SIGKILL"]


@pytest.mark.parametrize(("words", "acts"), [("end\n", False), ("30.0\n", True)])
def test_it_acts_for_a_dead_owner_unless_the_rig_was_given_back(monkeypatch, words, acts):
    with subprocess.Popen([sys.executable, "-c", ""]) as owner:
        pass
    stdin = io.StringIO(json.dumps({**TASK, "process": owner.pid}) + f"\n{words}")
    acted = []
    monkeypatch.setattr(main, "IGNORED", ())
    monkeypatch.setattr(main.sys, "stdin", stdin)
    monkeypatch.setattr(acting, "act", lambda _task, reason: acted.append(reason))
    assert main.main() == 0
    assert acted == [f"the process of a run ({owner.pid}) died"] * acts


def test_an_owner_that_died_before_it_said_what_to_guard_leaves_nothing_to_do(monkeypatch):
    monkeypatch.setattr(main, "IGNORED", ())
    monkeypatch.setattr(main.sys, "stdin", io.StringIO())
    monkeypatch.setattr(acting, "act", lambda *_: pytest.fail("it acted"))
    assert main.main() == 0


@pytest.mark.parametrize(("needed_s", "returns"), [(10.0, True), (0.0, False)])
def test_an_attempt_has_the_time_that_its_drives_need(monkeypatch, needed_s, returns):
    done = threading.Event()

    def attempt(_task, need):
        need(needed_s)
        done.wait(0.2 if returns else 10)
        return (), ""

    monkeypatch.setattr(acting, "ATTEMPT_S", 0.02)
    monkeypatch.setattr(acting, "_one_attempt", attempt)
    problem = "" if returns else "a device did not return within 0.02 s"
    assert acting._limited_attempt({}) == ((), problem)
    done.set()


def in_a_thread(work):
    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    return thread


def test_a_debugger_of_python_is_seen_in_the_thread_that_it_holds():
    locked, free = threading.Event(), threading.Event()

    class Held(bdb.Bdb):
        def user_line(self, frame):  # noqa: ARG002  (a debugger's)
            locked.set()
            free.wait(10)

    def debugged():
        Held().run("x = 1", {})

    thread = in_a_thread(debugged)
    assert locked.wait(10)
    assert debugger_at(thread)
    free.set()
    waiting = threading.Event()
    assert not debugger_at(in_a_thread(lambda: waiting.wait(10)))
    waiting.set()
    thread.join()


def test_a_guardian_that_waits_has_imported_the_standard_library_alone():
    script = "import rigrunner.run.guardian.main, sys; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-I", "-c", script], capture_output=True, text=True, check=True
    )
    top = {word.partition(".")[0] for word in done.stdout.split()}
    assert "rigrunner" in top
    assert not {"numpy", "pydantic", "yaml", "filelock", "pluggy", "click"} & top


def test_check_says_what_the_guardian_guards(tmp_path):
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
