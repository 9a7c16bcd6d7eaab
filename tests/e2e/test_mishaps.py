"""Disks and clocks that let a run down: the rig is safe, what was complete stays readable."""

from __future__ import annotations

import os
import shutil
import tempfile
from contextlib import contextmanager
from datetime import timedelta
from pathlib import Path

import pytest

import rigrunner
from e2e.helpers_resume import FEWER, NO_LOAD, interrupted, take_up
from helpers_cli import call
from helpers_workflow import START, quick_procedure, run
from rigrunner.api.errors import DataError, ExitCode
from rigrunner.api.events import Alarm, MadeSafe, Outcome, RunEnded, Samples, StepEnded
from rigrunner.clock import SimulatedClock
from rigrunner.runfile import read
from unit.runfile.helpers_runfile import disk_full_beyond

NOBODY = 65_534


class Safety:
    """Listens to how the drives were left."""

    def __init__(self) -> None:
        self.safe: list[MadeSafe] = []

    def __call__(self, event) -> None:
        if isinstance(event, MadeSafe):
            self.safe.append(event)

    @property
    def is_confirmed(self) -> bool:
        drives = {one.what: one for one in self.safe}
        return all(
            drives[drive].read_back[drive] == 0.0 and not drives[drive].problems
            for drive in ("tester.frequency", "tester.load")
        )


def in_recording(event, prefix):
    return isinstance(event, Samples) and event.recording.startswith(prefix)


@contextmanager
def filling_up(size):
    """Give a listener that lets no file grow beyond a size from the third recording on."""
    with disk_full_beyond(1 << 40):

        def listen(event):
            if in_recording(event, "003"):
                limit.__enter__()

        limit = disk_full_beyond(size)
        yield listen


def test_a_full_disk_ends_the_run_safely_and_it_goes_on_once_there_is_space(tmp_path):
    safety = Safety()
    procedure = quick_procedure(tmp_path, NO_LOAD, FEWER)
    with filling_up(1 << 12) as listen:
        finished = run(procedure, tmp_path / "runs", listeners=[listen, safety])
    assert finished.outcome is Outcome.ERROR
    assert finished.exit_code is ExitCode.DATA
    assert "free some space" in finished.error.hint
    assert not finished.sealed
    assert safety.is_confirmed
    stored = read(finished.folder)
    assert [one.name for one in stored.recordings] == ["001_8Hz", "002_15Hz"]
    resumed = take_up(finished.folder)
    assert resumed.outcome is Outcome.COMPLETED
    assert len(read(resumed.folder).recordings) == 5


@contextmanager
def read_only(folder: Path):
    """Let a folder be read only, for root as well: as somebody who has no rights there."""
    folder.chmod(0o555)
    is_root = os.geteuid() == 0
    if is_root:
        os.seteuid(NOBODY)
    try:
        yield
    finally:
        if is_root:
            os.seteuid(0)
        folder.chmod(0o755)


@pytest.fixture
def open_folder():
    """A folder that everyone may enter, unlike those of pytest; so must be the program's own."""
    above = Path(rigrunner.__file__).parents
    if os.geteuid() == 0 and not all(each.stat().st_mode & 0o001 for each in above):
        pytest.skip("the program lies where only root may go, and root must be somebody else here")
    folder = Path(tempfile.mkdtemp())
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="rights on folders are those of a Unix")
def test_a_read_only_folder_is_told_before_anything_moves(open_folder):
    procedure = quick_procedure(open_folder, NO_LOAD, FEWER)
    runs, safety = open_folder / "runs", Safety()
    runs.mkdir()
    with read_only(runs), pytest.raises(DataError, match=r"cannot write .*Permission") as caught:
        run(procedure, runs, listeners=[safety])
    assert "no permission to write there" in caught.value.hint
    assert list(runs.iterdir()) == []
    assert safety.safe == []


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="rights on folders are those of a Unix")
def test_a_folder_that_becomes_read_only_costs_nothing_that_was_complete(open_folder):
    procedure = quick_procedure(open_folder, NO_LOAD, FEWER)
    runs, safety = open_folder / "runs", Safety()
    held = []

    def lock_up(event):
        if isinstance(event, StepEnded) and event.recording.startswith("002") and not held:
            (folder,) = runs.iterdir()
            for each in (folder, folder / "journal", folder / "recordings"):
                each.chmod(0o555)
            held.append(read_only(folder))
            held[0].__enter__()

    finished = run(procedure, runs, listeners=[lock_up, safety])
    held[0].__exit__(None, None, None)
    (folder,) = runs.iterdir()
    for each in (folder, folder / "journal", folder / "recordings"):
        each.chmod(0o755)
    assert finished.outcome is Outcome.ERROR
    assert not finished.sealed
    assert safety.is_confirmed
    assert [one.name for one in read(folder).recordings] == ["001_8Hz", "002_15Hz"]
    shown = call("resume", folder.name, "--runs", runs, "--dry-run")
    assert "error at 2026" in shown.err
    assert "Permission denied" in shown.err
    assert "resumes at main[0]" in shown.err
    assert take_up(folder).outcome is Outcome.COMPLETED
    stored = read(folder)
    assert len(stored.recordings) == 5
    first, last = (one for one in stored.events if isinstance(one, RunEnded))
    assert (first.outcome, last.outcome) == (Outcome.ERROR, Outcome.COMPLETED)
    assert "Permission denied" in first.reason
    assert first.read_back == {"tester.frequency": 0.0, "tester.load": 0.0}
    assert (stored.info.outcome, stored.info.reason) == ("completed", "")
    report = (folder / "report.html").read_text(encoding="utf-8")
    assert "Permission denied" in report  # the record tells why it was taken up


@pytest.mark.skipif(os.name == "nt", reason="Windows lets nobody remove what is open")
def test_a_folder_that_is_gone_ends_the_run_safely_and_is_named(tmp_path):
    procedure, safety = quick_procedure(tmp_path, NO_LOAD, FEWER), Safety()
    gone = []

    def take_away(event):
        if in_recording(event, "002") and not gone:
            gone.extend((tmp_path / "runs").iterdir())
            shutil.rmtree(gone[0])

    finished = run(procedure, tmp_path / "runs", listeners=[take_away, safety])
    assert finished.outcome is Outcome.ERROR
    assert finished.exit_code is ExitCode.DATA
    assert gone[0].name in finished.error.message
    assert "was it deleted or moved, or its disk taken away?" in finished.error.hint
    assert safety.is_confirmed


class SetBack(SimulatedClock):
    """A clock that is set back by a day in the middle of a run."""

    is_set_back = False

    def utc(self):
        return super().utc() - timedelta(days=1) * self.is_set_back


def test_a_clock_that_is_set_back_is_told_and_changes_no_order(tmp_path):
    clock, alarms, ended = SetBack(START), [], []

    def listen(event):
        clock.is_set_back |= in_recording(event, "003")
        if isinstance(event, Alarm):
            alarms.append(event)
        if isinstance(event, RunEnded):
            ended.append(event)

    procedure = quick_procedure(tmp_path, NO_LOAD, FEWER)
    finished = run(procedure, tmp_path / "runs", clock=clock, listeners=[listen])
    assert finished.outcome is Outcome.COMPLETED
    (alarm,) = alarms
    assert "the clock was set back from 2026-03-01T12:0" in alarm.text
    stored = read(finished.folder)
    assert [one.name[:3] for one in stored.recordings] == ["001", "002", "003", "004", "005"]
    assert stored.info.ended_utc < stored.header.started_utc
    assert call("verify", finished.folder).code == ExitCode.PASS


def test_a_run_file_that_another_program_holds_is_told(tmp_path):
    fcntl = pytest.importorskip("fcntl", reason="locks of files are those of a Unix")
    finished = run(quick_procedure(tmp_path, NO_LOAD, FEWER), tmp_path / "runs")
    with (finished.folder / "run.h5").open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        told = call("show", finished.folder)
    assert told.code == ExitCode.DATA
    assert "is locked: another program has it open" in told.err
    assert "close it there" in told.err


def test_the_command_line_leads_from_a_interrupted_run_to_its_end(tmp_path):
    killed, _ = interrupted(tmp_path, lambda event: in_recording(event, "002"))
    runs, name = killed.parent, killed.name
    listed = call("runs", "--runs", runs)
    assert f"{name}  interrupted" in listed.out
    assert "'rigrunner resume RUN'" in listed.err
    assert "'rigrunner recover RUN'" in listed.err
    shown = call("resume", name, "--runs", runs, "--dry-run")
    assert shown.code == ExitCode.PASS
    assert "finished recordings: 001_8Hz" in shown.err
    assert "interrupted: 002_15Hz, of which" in shown.err
    assert "resumes at main[0].sweep[1].set: Set tester.frequency to 15 Hz" in shown.err
    assert not read(killed).info.sealed
    copy = runs / "copy"
    shutil.copytree(killed, copy)
    done = call("resume", name, "--runs", runs, "--unattended", "--by", "A. Jones")
    assert done.code == ExitCode.PASS, done.err
    assert "report.html" in done.out
    again = call("resume", name, "--runs", runs)
    assert again.code == ExitCode.DATA
    assert "has ended and is sealed" in again.err
    closed = call("recover", "copy", "--runs", runs, "--by", "B. Smith", "--reason", "broken belt")
    assert closed.code == ExitCode.PASS
    assert "aborted, sealed" in closed.out
    assert "The rig was not touched" in closed.err
    assert call("report", copy).code == ExitCode.PASS
    assert "aborted" in (copy / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("command", ["resume", "recover"])
def test_what_is_no_run_is_refused_by_name(tmp_path, command):
    assert "there is no run 'nothing'" in call(command, "nothing", "--runs", tmp_path).err
    (tmp_path / "empty").mkdir()
    told = call(command, "empty", "--runs", tmp_path)
    assert told.code == ExitCode.DATA
    assert "is not a run" in told.err
