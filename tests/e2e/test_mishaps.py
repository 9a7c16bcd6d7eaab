"""Failing disks and clocks: the rig is made safe, complete recordings stay readable."""

from __future__ import annotations

import os
import shutil
import tempfile
from contextlib import contextmanager
from datetime import timedelta
from pathlib import Path

import pytest

import rigrunner
from e2e.helpers_resume import FEWER, NO_LOAD, interrupted, resume_run
from helpers_cli import call
from helpers_workflow import START, quick_procedure, run
from rigrunner.api.errors import DataError, ExitCode
from rigrunner.api.events import Alarm, MadeSafe, Outcome, RunEnded, Samples, StepEnded
from rigrunner.clock import SimulatedClock
from rigrunner.runfile import read
from unit.runfile.helpers_runfile import disk_full_beyond

NOBODY = 65_534


class Safety:
    """Collects the events that made the drives safe."""

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


def is_samples_of(event, prefix):
    return isinstance(event, Samples) and event.recording.startswith(prefix)


@contextmanager
def disk_full_from_third_recording(size):
    """Yield a listener that limits the size of files from the third recording on."""
    with disk_full_beyond(1 << 40):

        def listen(event):
            if is_samples_of(event, "003"):
                limit.__enter__()

        limit = disk_full_beyond(size)
        yield listen


def test_full_disk_ends_the_run_safely_and_it_resumes_with_space(tmp_path):
    safety = Safety()
    procedure = quick_procedure(tmp_path, NO_LOAD, FEWER)
    with disk_full_from_third_recording(1 << 12) as listen:
        finished = run(procedure, tmp_path / "runs", listeners=[listen, safety])
    assert finished.outcome is Outcome.ERROR
    assert finished.exit_code is ExitCode.DATA
    assert "free some space" in finished.error.hint
    assert not finished.sealed
    assert safety.is_confirmed
    stored = read(finished.folder)
    assert [one.name for one in stored.recordings] == ["001_8Hz", "002_15Hz"]
    resumed = resume_run(finished.folder)
    assert resumed.outcome is Outcome.COMPLETED
    assert len(read(resumed.folder).recordings) == 5


@contextmanager
def read_only(folder: Path):
    """Make a folder read-only, for root as well: by another user without rights to it."""
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
    """A folder that every user may enter, unlike those of pytest; the program's must be so too."""
    parents = Path(rigrunner.__file__).parents
    if os.geteuid() == 0 and not all(parent.stat().st_mode & 0o001 for parent in parents):
        pytest.skip("the program is where only root may go, and this test drops root's rights")
    folder = Path(tempfile.mkdtemp())
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="rights on folders are those of a Unix")
def test_read_only_folder_is_refused_before_anything_moves(open_folder):
    procedure = quick_procedure(open_folder, NO_LOAD, FEWER)
    runs, safety = open_folder / "runs", Safety()
    runs.mkdir()
    with read_only(runs), pytest.raises(DataError, match=r"cannot write .*Permission") as caught:
        run(procedure, runs, listeners=[safety])
    assert "no permission to write there" in caught.value.hint
    assert list(runs.iterdir()) == []
    assert safety.safe == []


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="rights on folders are those of a Unix")
def test_complete_recordings_survive_a_folder_turning_read_only(open_folder):
    procedure = quick_procedure(open_folder, NO_LOAD, FEWER)
    runs, safety = open_folder / "runs", Safety()
    locked = []

    def lock_up(event):
        if isinstance(event, StepEnded) and event.recording.startswith("002") and not locked:
            (folder,) = runs.iterdir()
            for path in (folder, folder / "journal", folder / "recordings"):
                path.chmod(0o555)
            locked.append(read_only(folder))
            locked[0].__enter__()

    finished = run(procedure, runs, listeners=[lock_up, safety])
    locked[0].__exit__(None, None, None)
    (folder,) = runs.iterdir()
    for path in (folder, folder / "journal", folder / "recordings"):
        path.chmod(0o755)
    assert finished.outcome is Outcome.ERROR
    assert not finished.sealed
    assert safety.is_confirmed
    assert [one.name for one in read(folder).recordings] == ["001_8Hz", "002_15Hz"]
    shown = call("resume", folder.name, "--runs", runs, "--dry-run")
    assert "error at 2026" in shown.err
    assert "Permission denied" in shown.err
    assert "resumes at main[0]" in shown.err
    assert resume_run(folder).outcome is Outcome.COMPLETED
    stored = read(folder)
    assert len(stored.recordings) == 5
    first, last = (one for one in stored.events if isinstance(one, RunEnded))
    assert (first.outcome, last.outcome) == (Outcome.ERROR, Outcome.COMPLETED)
    assert "Permission denied" in first.reason
    assert first.read_back == {"tester.frequency": 0.0, "tester.load": 0.0}
    assert (stored.info.outcome, stored.info.reason) == ("completed", "")
    report = (folder / "report.html").read_text(encoding="utf-8")
    assert "Permission denied" in report  # the record says why it was resumed


@pytest.mark.skipif(os.name == "nt", reason="Windows lets nobody remove what is open")
def test_deleted_folder_ends_the_run_safely_and_is_named(tmp_path):
    procedure, safety = quick_procedure(tmp_path, NO_LOAD, FEWER), Safety()
    deleted = []

    def take_away(event):
        if is_samples_of(event, "002") and not deleted:
            deleted.extend((tmp_path / "runs").iterdir())
            # At once: a recording is being folded there.
            shutil.rmtree(deleted[0].rename(tmp_path / "away"), ignore_errors=True)

    finished = run(procedure, tmp_path / "runs", listeners=[take_away, safety])
    assert finished.outcome is Outcome.ERROR
    assert finished.exit_code is ExitCode.DATA
    assert deleted[0].name in finished.error.message
    assert "was it deleted or moved, or its disk taken away?" in finished.error.hint
    assert safety.is_confirmed


class SetBack(SimulatedClock):
    """A clock that is set back by a day during a run."""

    is_set_back = False

    def utc(self):
        return super().utc() - timedelta(days=1) * self.is_set_back


def test_clock_set_back_raises_an_alarm_and_keeps_the_order(tmp_path):
    clock, alarms, ended = SetBack(START), [], []

    def listen(event):
        clock.is_set_back |= is_samples_of(event, "003")
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


def test_run_file_locked_by_another_program_is_reported(tmp_path):
    fcntl = pytest.importorskip("fcntl", reason="locks of files are those of a Unix")
    finished = run(quick_procedure(tmp_path, NO_LOAD, FEWER), tmp_path / "runs")
    with (finished.folder / "run.h5").open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        shown = call("show", finished.folder)
    assert shown.code == ExitCode.DATA
    assert "is locked: another program has it open" in shown.err
    assert "close it there" in shown.err


def test_commands_resume_or_recover_an_interrupted_run(tmp_path):
    killed, _ = interrupted(tmp_path, lambda event: is_samples_of(event, "002"))
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
    resumed = call("resume", name, "--runs", runs, "--unattended", "--by", "A. Jones")
    assert resumed.code == ExitCode.PASS, resumed.err
    assert "report.html" in resumed.out
    refused = call("resume", name, "--runs", runs)
    assert refused.code == ExitCode.DATA
    assert "has ended and is sealed" in refused.err
    recovered = call(
        "recover", "copy", "--runs", runs, "--by", "B. Smith", "--reason", "broken belt"
    )
    assert recovered.code == ExitCode.PASS
    assert "aborted, sealed" in recovered.out
    assert "The rig was not touched" in recovered.err
    assert call("report", copy).code == ExitCode.PASS
    assert "aborted" in (copy / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("command", ["resume", "recover"])
def test_folder_without_a_run_is_refused_by_name(tmp_path, command):
    assert "there is no run 'nothing'" in call(command, "nothing", "--runs", tmp_path).err
    (tmp_path / "empty").mkdir()
    refused = call(command, "empty", "--runs", tmp_path)
    assert refused.code == ExitCode.DATA
    assert "is not a run" in refused.err
