"""The guardian makes the rig safe, and reports it, if the process of a run ends or hangs."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager, suppress

import psutil
import pytest

from e2e.helpers_panel import Screen, ready, rig_process, served
from e2e.helpers_supply import GUARDED, SupplyLab
from helpers_thorough import first
from rigrunner.api.events import Alarm, Intervention, MadeSafe, RunEnded, StepStarted
from rigrunner.rig_state import read_marker
from rigrunner.runfile import read

pytestmark = [
    pytest.mark.skipif(not hasattr(os, "fork"), reason="kill -9 and SIGSTOP are of POSIX"),
    pytest.mark.in_real_time,
]
PROGRAM = (sys.executable, "-m", "rigrunner")
PATIENCE_S = 120.0
LIMIT_S, GRACE_S = 10.0, 10.0
"""The guardian's patience on these stations, for a heartbeat and after SIGTERM."""
ENERGISED_THEN_ASKED = """\
rigrunner: procedure/2
id: ASKS
revision: "A"
title: A question under voltage
measurand: {symbol: U, name: voltage}
uses: {psu: supply}
main:
  - set: {psu.voltage: 40 V}
  - confirm: {text: "Is the lamp lit?", unattended: yes}
  - wait: {time: 12 s}
  - measure: {channels: [psu.voltage], name: steps}
"""


class Run:
    """A run in its own process, with its own supply."""

    def __init__(
        self, folder, name, *words, trouble="", station=(GUARDED,), procedure="", locks="rigs"
    ):
        self.lab = SupplyLab(folder / name, name)
        self.lab.add_station("station.yaml", name, *station)
        if trouble:
            (self.lab.folder / "trouble").write_text(trouble, encoding="utf-8")
        if procedure:
            self.lab.procedure.write_text(procedure, encoding="utf-8")
        lab = self.lab
        self.words = ["run", lab.procedure, "--station", lab.station, "--runs", lab.runs, *words]
        self.locks = folder / locks
        self.process = subprocess.Popen(
            [*PROGRAM, *map(str, self.words)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=os.environ | {"RIGRUNNER_LOCKS": str(self.locks)},
            text=True,
        )

    def until(self, condition):
        until_s = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < until_s
            time.sleep(0.005)

    def until_energised(self):
        self.until(lambda: self.lab.outputs()[0] == 40.0 or self.process.poll() is not None)
        assert self.process.poll() is None, self.output()
        return self

    def until_waiting(self):
        """Wait until no driver call is in progress: one stopped halfway would time out."""
        self.until(lambda: any(_is_wait(event) for event in read(self.folder()).events))
        return self

    def until_safe(self):
        self.until(lambda: self.lab.outputs() == (0.0, 0.0))

    def guardian(self):
        for child in psutil.Process(self.process.pid).children():
            with suppress(psutil.Error):  # it may just have ended
                if "rigrunner.run.guardian.main" in child.cmdline():
                    return child
        return None

    def output(self):
        """Return all output of the run and its guardian, which ends with the guardian."""
        return self.process.communicate(timeout=PATIENCE_S)[0]

    def folder(self):
        (folder,) = self.lab.runs.iterdir()
        return folder


@pytest.fixture
def rigs(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))
    with ExitStack() as stack:
        yield lambda *words, **more: ended_at_exit(stack, Run(tmp_path, *words, **more))


def _is_wait(event):
    return isinstance(event, StepStarted) and event.action == "wait"


def ended_at_exit(stack, run):
    stack.callback(_end, run.process)
    return run


def _end(process):
    process.kill()
    process.communicate()


def assert_reported(run, reason):
    """Check run folder, journal, marker and terminal for what was done."""
    output = run.output()
    assert reason in output
    assert "the rig is safe: every drive was read back at its safe value" in output
    for name in ("guardian.txt", "run.log"):
        text = (run.folder() / name).read_text(encoding="utf-8")
        assert reason in text
        assert "psu is safe: read back voltage 0 V, speed 0 Hz" in text
    events = read(run.folder()).events
    (alarm,) = [e for e in events if isinstance(e, Alarm) and e.source == "guardian"]
    assert reason in alarm.text
    assert "psu.speed 20 Hz" in alarm.text
    (made,) = [e for e in events if isinstance(e, MadeSafe)]
    assert (made.what, made.problems) == ("psu", ())
    assert made.read_back == {"psu.voltage": 0.0, "psu.speed": 0.0}
    marker = read_marker(run.lab.station_id)
    assert marker.safe_by.startswith("The guardian made it safe at ")
    assert marker.owner.guardian == "a second process"


@pytest.mark.parametrize("number", first(1, [signal.SIGKILL, signal.SIGABRT, signal.SIGSEGV]))
def test_killed_run_leaves_a_safe_rig(rigs, number):
    run = rigs("killed", "--unattended").until_energised()
    run.process.send_signal(number)
    assert run.process.wait(PATIENCE_S) == -number
    run.until_safe()
    assert_reported(run, f"({run.process.pid}) died")


@pytest.mark.thorough
@pytest.mark.parametrize("trouble", ["abort", "crash"])
def test_crashing_driver_leaves_a_safe_rig(rigs, trouble):
    run = rigs("crashed", "--unattended", trouble=trouble)
    assert run.process.wait(PATIENCE_S) in (-signal.SIGABRT, -signal.SIGSEGV)
    run.until_safe()
    assert_reported(run, f"({run.process.pid}) died")


@pytest.mark.thorough
def test_hanging_runs_are_ended_and_waiting_ones_are_not(rigs):
    """All at the same time, since each takes as long as the guardian waits."""
    hanging = [
        rigs("gil", "--unattended", trouble="gil", locks="1"),
        rigs("inline", "--unattended", trouble="sleep", station=(GUARDED, INLINE), locks="2"),
        rigs("stopped", "--unattended", procedure=ENERGISED_THEN_ASKED, locks="3")
        .until_energised()
        .until_waiting(),
    ]
    hanging[2].process.send_signal(signal.SIGSTOP)
    asking = rigs("asked", procedure=ENERGISED_THEN_ASKED, locks="4").until_energised()
    traced = rigs(
        "traced", "--unattended", procedure=ENERGISED_THEN_ASKED, locks="5"
    ).until_energised()
    with traced_by_a_debugger(traced.process.pid) as is_traced:
        traced.process.send_signal(signal.SIGSTOP)
        start_s = time.monotonic()
        for run in hanging:
            run.until_safe()
            run.process.wait(PATIENCE_S)
            assert "asked to end (SIGTERM)" in (output := run.output())
            assert "NOT SAFE" not in output
        assert hanging[0].process.returncode == -signal.SIGKILL  # SIGTERM has no effect
        assert "hung, and was ended" in (hanging[0].folder() / "guardian.txt").read_text()
        assert hanging[2].process.returncode == 20  # SIGTERM was handled when it was continued
        (ended,) = [e for e in read(hanging[2].folder()).events if isinstance(e, RunEnded)]
        assert "SIGTERM" in ended.reason
        time.sleep(max(0.0, LIMIT_S + GRACE_S + 8.0 - (time.monotonic() - start_s)))
        for run in (asking, *[traced] * is_traced):
            assert run.process.poll() is None
            assert run.lab.outputs()[0] == 40.0
    traced.process.send_signal(signal.SIGCONT)
    output = traced.output()
    assert not is_traced or (traced.process.returncode, "asked to end" in output) == (0, False)
    output = asking.process.communicate("yes\n", timeout=PATIENCE_S)[0]
    assert (asking.process.returncode, "asked to end" in output) == (0, False)


INLINE = ("{file: supply.json}", "{file: supply.json, non_blocking: true}")
DEBUGGER = """
import ctypes, os, sys
pid, libc = int(sys.argv[1]), ctypes.CDLL(None, use_errno=True)
libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
print(libc.ptrace(0x4206, pid, None, None), flush=True)  # PTRACE_SEIZE
sys.stdin.read()  # ends the trace on exit
"""


@contextmanager
def traced_by_a_debugger(pid):
    """Trace a process as gdb does, from another process; yield whether this is allowed."""
    with subprocess.Popen(
        [sys.executable, "-c", DEBUGGER, str(pid)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as debugger:
        yield sys.platform == "linux" and debugger.stdout.readline().strip() == "0"
        debugger.stdin.close()


def test_killed_guardian_is_replaced_and_recorded(rigs):
    run = rigs("replaced", "--unattended", procedure=ENERGISED_THEN_ASKED).until_energised()
    first = run.guardian()
    first.kill()
    run.until(lambda: (guardian := run.guardian()) is not None and guardian.pid != first.pid)
    time.sleep(2.0)  # it says so within milliseconds
    run.process.kill()
    run.until_safe()
    output = run.output()
    assert f"the guardian (process {first.pid}) ended with code -9; process " in output
    assert "guards the rig now" in output


@pytest.mark.thorough
def test_lost_guardian_is_recorded_in_the_run(rigs):
    run = rigs("lost", "--unattended", procedure=ENERGISED_THEN_ASKED).until_energised()
    first = run.guardian()
    first.kill()
    run.output()
    assert run.process.returncode == 0
    alarms = [e.text for e in read(run.folder()).events if isinstance(e, Alarm)]
    assert any(f"the guardian (process {first.pid}) ended with code -9" in text for text in alarms)


@pytest.mark.thorough
def test_rig_stays_locked_until_the_guardian_is_done(rigs):
    run = rigs("gap", "--unattended").until_energised()
    run.lab.put(is_held=True)
    run.process.kill()
    run.process.wait()
    second = subprocess.run(
        [*PROGRAM, *map(str, run.words)], capture_output=True, text=True, check=False
    )
    assert second.returncode == 4
    assert "is in use" in second.stderr
    run.lab.put(is_held=False)
    run.until_safe()
    run.output()
    third = subprocess.run(
        [*PROGRAM, *map(str, run.words)], capture_output=True, text=True, check=False
    )
    assert third.returncode == 0, third.stderr
    assert "The guardian made it safe" in third.stderr


def test_guardian_ignores_terminal_signals_and_ends_with_its_run(rigs):
    run = rigs("ends", "--unattended").until_energised()
    guardian = run.guardian()
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM, signal.SIGQUIT):
        guardian.send_signal(number)
    time.sleep(0.2)
    assert guardian.is_running()
    output = run.output()
    assert run.process.returncode == 0
    assert "guardian:" not in output
    assert not psutil.pid_exists(guardian.pid)
    assert read_marker("ends") is None
    assert not (run.folder() / "guardian.txt").exists()
    assert not [e for e in read(run.folder()).events if isinstance(e, Intervention)]


def test_rig_without_lock_folder_is_made_safe(rigs):
    run = rigs("cleaned", "--unattended").until_energised()
    shutil.rmtree(run.locks)
    run.process.kill()
    output = run.output()
    assert "set-points not known. Making the rig safe." in output
    assert "the rig is safe: every drive was read back at its safe value" in output
    assert run.lab.outputs() == (0.0, 0.0)


@pytest.mark.thorough
def test_removed_lock_files_are_restored(rigs):
    procedure = ENERGISED_THEN_ASKED.replace("12 s", "120 s")  # for a slow machine
    run = rigs("kept", "--unattended", procedure=procedure).until_energised()
    for path in run.locks.iterdir():
        path.unlink()
    run.until(lambda: len(list(run.locks.glob("*.lock"))) == 2)
    second = subprocess.run(
        [*PROGRAM, *map(str, run.words)], capture_output=True, text=True, check=False
    )
    assert second.returncode == 4
    assert f"is in use: ASKS, process {run.process.pid}" in second.stderr
    run.process.kill()
    assert "last set-points: psu.voltage 40 V. Making the rig safe." in run.output()
    assert run.lab.outputs() == (0.0, 0.0)


def test_station_without_a_guardian_records_it(rigs):
    run = rigs("none", "--unattended", station=()).until_energised()
    assert run.guardian() is None
    output = run.output()
    assert "there is no guardian, as the station says" in output
    (intervention,) = [e for e in read(run.folder()).events if isinstance(e, Intervention)]
    assert (intervention.action, intervention.by) == ("guardian", "station")
    assert "there is no guardian" in intervention.subject


@pytest.mark.thorough
def test_device_that_cannot_be_reopened_is_reported(rigs):
    run = rigs("alone", "--unattended", station=())  # for the lab alone
    run.output()
    lab = run.lab
    lab.add_station("station.yaml", "alone", GUARDED)
    lab.procedure.write_text(ENERGISED_THEN_ASKED, encoding="utf-8")
    plugin = lab.folder / "plugins" / "supply.py"
    text = plugin.read_text(encoding="utf-8")
    plugin.write_text(text.replace("factory=Supply,", "factory=Supply, reopenable=False,"))
    command = [*PROGRAM, *map(str, run.words)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as killed:
        run.until(lambda: lab.outputs()[0] == 40.0)
        killed.kill()
        output = killed.stderr.read()
    assert "THE RIG IS NOT SAFE: psu: its plugin says that no second process can open it" in output
    assert lab.outputs()[0] == 40.0
    marker = read_marker("alone")
    assert not marker.safe_by
    assert "psu.voltage 40 V" in marker.text
    assert marker.text.endswith("; no second process can open psu")


def test_killed_jog_leaves_a_safe_rig(rigs, tmp_path):
    run = rigs("jogged", "--unattended", station=())  # for the lab alone
    run.output()
    station = run.lab.add_station("guarded.yaml", "jogged", GUARDED)
    log = tmp_path / "jog.log"
    words = [*PROGRAM, "jog", str(station), "psu", "--log", str(log)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, text=True) as jog:
        jog.stdin.write("set voltage 40 V\n")
        jog.stdin.flush()
        run.until(lambda: run.lab.outputs()[0] == 40.0)
        jog.kill()
    run.until_safe()
    run.until(lambda: "guardian: the rig is safe" in log.read_text(encoding="utf-8"))


def test_late_guardian_acts_after_its_owner_died(rigs):
    run = rigs("late", "--unattended", station=())  # for the lab alone
    run.output()
    lab = run.lab
    station = lab.add_station("guarded.yaml", "late", GUARDED)
    late = subprocess.run(
        [sys.executable, "-c", LATE, str(station)], capture_output=True, text=True, check=False
    )
    assert late.returncode == -signal.SIGKILL
    run.until_safe()
    run.until(lambda: read_marker("late").safe_by)


LATE = """
import os, signal, sys, pathlib, subprocess, time
from rigrunner.tools.by_hand.station import ready_station

def stop_at_once(*words, popen=subprocess.Popen, **known):
    child = popen(*words, **known)
    child.send_signal(signal.SIGSTOP)
    return child

subprocess.Popen = stop_at_once
with ready_station(pathlib.Path(sys.argv[1])).hold("late") as held:
    with held.guarded("late", {"psu"}) as guardian, held.rig({"psu"}, guardian.pulse) as rig:
        rig.set("psu", "voltage", 40.0)
        child, owner = guardian._child.pid, os.getpid()
        if os.fork() == 0:  # continues the guardian once its owner is dead
            while os.getppid() == owner:
                time.sleep(0.01)
            os.kill(child, signal.SIGCONT)
            os._exit(0)
        os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.thorough
def test_run_at_the_panel_has_a_guardian(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))
    lab = SupplyLab(tmp_path / "lab", "panel")
    lab.add_station("station.yaml", "panel", GUARDED)
    lab.procedure.write_text(ENERGISED_THEN_ASKED, encoding="utf-8")
    with served(lab.folder, lab.runs) as server:
        screen = Screen(server, "client-ann-0001")
        pair = ready(screen, "procedure.yaml")
        screen.post("run/start", 202, **pair, operator="Ann")
        screen.until(lambda state: state["prompt"])
        assert lab.outputs()[0] == 40.0
        os.kill(rig_process(server), signal.SIGKILL)
        screen.phase("finished")
        until_s = time.monotonic() + PATIENCE_S
        while lab.outputs() != (0.0, 0.0):
            assert time.monotonic() < until_s
            time.sleep(0.01)
        screen.close()


@pytest.mark.thorough
def test_killed_rig_at_the_panel_does_not_affect_the_other(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))
    lab = SupplyLab(tmp_path / "lab", "first")
    lab.add_station("station.yaml", "first", GUARDED)
    lab.add_station("other.yaml", "second", GUARDED, ("supply.json", "other.json"))
    other_state = lab.folder / "other.json"
    other_state.write_text(lab.state.read_text())
    text = ENERGISED_THEN_ASKED.replace("wait: {time: 12 s}", "wait: {time: 0.1 s}")
    lab.procedure.write_text(text, encoding="utf-8")

    def other_voltage():
        return json.loads(other_state.read_text())["voltage"]

    with served(lab.folder, lab.runs) as server:
        rigs = {"client-first": "station.yaml", "client-second": "other.yaml"}
        screens = [Screen(server, client, rig) for client, rig in rigs.items()]
        killed, other = screens
        pair = ready(killed, "procedure.yaml")
        killed.post("run/start", 202, **pair, operator="Ann")
        killed.until(lambda state: state["prompt"])
        killed_process = rig_process(server)
        pair = ready(other, "procedure.yaml", "other.yaml", "Bob")
        other.post("run/start", 202, **pair, operator="Bob")
        other.until(lambda state: state["prompt"])
        assert (lab.outputs()[0], other_voltage()) == (40.0, 40.0)

        os.kill(killed_process, signal.SIGKILL)
        killed.phase("finished")
        until_s = time.monotonic() + PATIENCE_S
        while lab.outputs() != (0.0, 0.0):
            assert time.monotonic() < until_s
            time.sleep(0.01)
        assert (other.state["phase"], other_voltage()) == ("asking", 40.0), "untouched"
        # the values that the guardian read back, with their time
        state = killed.until(lambda state: state["readings"]["psu.voltage"]["value"] == 0.0)
        (safe,) = (channel for channel in state["channels"] if channel["name"] == "psu.voltage")
        assert (safe["value"], safe["utc"] > state["job"]["started_utc"]) == (0.0, True)

        other.answer()
        finished = other.phase("finished")["finished"]
        assert (finished["outcome"], other_voltage()) == ("completed", 0.0)
        assert read(lab.runs / finished["run"]).info.sealed
        for screen in screens:
            screen.close()
