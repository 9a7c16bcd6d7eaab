"""Real signals to a real process: it ends safe, sealed, and with the documented exit code."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from pathlib import Path

import pytest

from e2e.helpers_every_step import FAST
from e2e.helpers_terminal import PROGRAM, Terminal
from helpers_workflow import edited
from rigrunner.api.events import Intervention, MadeSafe, RunEnded, StepEnded
from rigrunner.ending import ENDING, SUSPENDING, signal_name
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.runfile import read

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="signals of Unix")
REALTIME = range(getattr(signal, "SIGRTMIN", 0), getattr(signal, "SIGRTMAX", 0) + 1)
STANDSTILL = {"tester.frequency": 0.0, "tester.load": 0.0}


@pytest.fixture
def lab(tmp_path):
    """A sweep of two points that takes some seconds of real time, and a rig with fast drives."""
    shipped = find_procedure("no_load_inertia_sweep")
    text = shipped.read_text(encoding="utf-8")
    start, end = text.index("  frequencies: ["), text.index("\n\nsetup:")
    analysis = text[text.index("\nanalysis:") :]
    edited(
        shipped,
        tmp_path / "sweep.yaml",
        points=(text[start:end], "  frequencies: [20 Hz, 25 Hz]"),
        short=("cycles: 30}", "cycles: 40}"),
        analysis=(analysis, "\n"),
    )
    edited(find_station("simulated"), tmp_path / "rig.yaml", fast=("{seed: 1}", FAST))
    return tmp_path


def arguments(*more: str) -> tuple[str, ...]:
    return ("run", "sweep.yaml", "--station", "rig.yaml", "--realtime", *more)


def stored(lab):
    (folder,) = (lab / "runs").iterdir()
    run = read(folder)
    assert run.info.sealed
    (ended,) = [one for one in run.events if isinstance(one, RunEnded)]
    assert ended.read_back == STANDSTILL
    made_safe = [one for one in run.events if isinstance(one, MadeSafe)]
    assert made_safe
    assert all(one.problems == () for one in made_safe)
    return run


def interventions(run) -> list[tuple[str, str]]:
    return [(one.action, one.by) for one in run.events if isinstance(one, Intervention)]


USUAL = ("SIGTERM", "SIGTSTP", "SIGINT")
ENDED_BY = [
    pytest.param(number, code, marks=[pytest.mark.thorough] * (signal_name(number) not in USUAL))
    for number, code in (
        *((number, 20) for number in (*ENDING, *SUSPENDING) if number not in REALTIME[1:-1]),
        (signal.SIGINT, 130),
    )
]


@pytest.mark.parametrize(("number", "code"), ENDED_BY, ids=signal_name)
def test_signal_aborts_an_unattended_run(lab, number, code):
    """Including SIGTSTP and the like, where no shell could continue the program."""
    command = [*PROGRAM, *arguments("--unattended")]
    with subprocess.Popen(
        command, cwd=lab, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        for line in process.stderr:
            if "Record" in line:
                break
        process.send_signal(number)
        process.stderr.read()
        assert process.wait(timeout=200) == code
    run = stored(lab)
    assert run.info.outcome == "aborted"
    assert interventions(run)[-1][0] == "abort"
    if number != signal.SIGINT:
        assert signal_name(number) in run.info.reason


def test_every_signal_is_documented():
    page = (Path(__file__).parents[2] / "docs/reference/faults.md").read_text(encoding="utf-8")
    table = page.partition("## Signals")[2].partition("\n## ")[0]
    handled = {signal_name(number) for number in (*ENDING, *SUSPENDING)} - {
        signal_name(number) for number in REALTIME[1:-1]
    }
    documented = set(re.findall(r"SIG[A-Z0-9]+", table))
    assert handled <= documented
    all_signals = {member.name for member in signal.Signals} - {"SIGCLD", "SIGPOLL", "SIGIOT"}
    assert all_signals <= documented | {"SIGBREAK"}


def test_signal_ignored_at_the_start_stays_ignored(lab):
    ignoring = ("nohup", *PROGRAM, *arguments("--unattended"))
    with subprocess.Popen(ignoring, cwd=lab, stderr=subprocess.PIPE, text=True) as process:
        for line in process.stderr:
            if "Record" in line:
                break
        process.send_signal(signal.SIGHUP)
        process.stderr.read()
        assert process.wait(timeout=200) == 0
    assert stored(lab).info.outcome == "completed"


def test_ctrl_z_makes_safe_before_suspending_and_fg_tells_the_outcome(lab):
    shell = ("bash", "--norc", "--noprofile", "-i")
    with Terminal((), str(lab), shell) as terminal:
        terminal.type("PS1='prompt> '\n")
        terminal.wait_for("prompt> ")
        terminal.type(" ".join((*PROGRAM, *arguments("--set", "operator=Ada"))) + "\n")
        terminal.wait_for("[yes/no]")
        terminal.type("yes\n")
        terminal.wait_for("Record")
        terminal.press_ctrl_z()
        terminal.wait_for("SIGTSTP")
        terminal.wait_for("Stopped")
        run = stored(lab)  # it is sealed, and the rig safe, while the program is suspended
        assert run.info.outcome == "aborted"
        assert "SIGTSTP" in run.info.reason
        terminal.wait_for("prompt> ")
        terminal.type("fg\n")
        terminal.wait_for("Continued. The run ended as aborted")
        terminal.wait_for("tester.frequency 0")
        terminal.wait_for("prompt> ")
        terminal.type("echo code=$?\n")
        terminal.wait_for("code=20")


def test_ctrl_z_while_jogging_makes_safe_before_suspending(lab):
    shell = ("bash", "--norc", "--noprofile", "-i")
    with Terminal((), str(lab), shell) as terminal:
        terminal.type("PS1='prompt> '\n")
        terminal.wait_for("prompt> ")
        terminal.type(" ".join((*PROGRAM, "jog", "rig.yaml", "tester", "--realtime")) + "\n")
        terminal.wait_for("tester>")
        terminal.type("set frequency 5 Hz\n")
        terminal.wait_for("reads back 5")
        terminal.press_ctrl_z()
        terminal.wait_for("Stopped")
        assert "tester is safe" in terminal.passed
        terminal.wait_for("prompt> ")
        terminal.type("fg\n")
        terminal.wait_for("Continued.")
        terminal.wait_for("prompt> ")


def test_ctrl_c_pauses_and_every_decision_is_on_record(lab):
    with Terminal(arguments("--set", "operator=Ada"), str(lab)) as terminal:
        terminal.wait_for("[yes/no]")
        terminal.type("yes\n")
        terminal.wait_for("Record")
        terminal.press_ctrl_c()
        terminal.wait_for("What now?")
        terminal.type("perhaps\n")
        terminal.wait_for("Please answer with one of: resume")
        terminal.type("note\n")
        terminal.wait_for("Your note:")
        terminal.type("it squeaked\n")
        terminal.wait_for("What now?")
        terminal.type("rep\n")
        terminal.wait_for("Record")
        terminal.press_ctrl_c()
        terminal.wait_for("What now?")
        terminal.type("skip\n")
        terminal.wait_for("Why?")
        terminal.type("no time\n")
        assert terminal.ends_with() == 10
    run = stored(lab)
    assert run.info.outcome == "completed"
    assert "skipped by Ada: no time" in run.info.reason
    assert interventions(run) == [
        ("pause", "keyboard"), ("repeat", "Ada"), ("pause", "keyboard"), ("skip", "Ada"),
    ]  # fmt: skip
    finished_steps = [(one.recording, one.ok) for one in run.events if getattr(one, "recording", "")
            and isinstance(one, StepEnded)]  # fmt: skip
    assert (finished_steps[0], finished_steps[-1]) == (("001_20Hz", False), ("002_25Hz", True))
    assert run.info.recording_names == ("002_25Hz",)


def test_ctrl_c_twice_aborts(lab):
    with Terminal(arguments(), str(lab)) as terminal:
        for answer in ("Bob\n", "yes\n"):
            terminal.wait_for("name:" if "Bob" in answer else "[yes/no]")
            terminal.type(answer)
        terminal.wait_for("Record")
        terminal.press_ctrl_c()
        terminal.wait_for("What now?")
        terminal.press_ctrl_c()
        assert terminal.ends_with() == 130
    run = stored(lab)
    assert (run.info.outcome, interventions(run)[-1]) == ("aborted", ("abort", "keyboard"))


def test_closed_terminal_leaves_the_rig_safe_and_the_run_sealed(lab):
    with Terminal(arguments("--set", "operator=Ada"), str(lab)) as terminal:
        terminal.wait_for("[yes/no]")
        terminal.type("yes\n")
        terminal.wait_for("Record")
        terminal.hang_up()
        assert terminal.ends_with() == 20
    assert stored(lab).info.outcome == "aborted"


def test_terminal_closed_at_a_question_aborts_the_run(lab):
    with Terminal(arguments("--set", "operator=Ada"), str(lab)) as terminal:
        terminal.wait_for("[yes/no]")
        terminal.hang_up()
        assert terminal.ends_with() == 20
    assert stored(lab).info.outcome == "aborted"
