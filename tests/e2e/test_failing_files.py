"""Each operation on a file of a run fails: the rig is made safe, and the file is named."""

from __future__ import annotations

import builtins
import errno
import io
import os
import re
import shutil
import sys
import threading
from pathlib import Path

import pytest

from helpers_workflow import START, registry, station_file
from rigrunner.api.errors import ExitCode, RigrunnerError
from rigrunner.api.events import MadeSafe, Outcome, RunEnded, RunStarted, StepEnded
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import execute
from rigrunner.runfile import read

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="it looks into /proc")
PROCEDURE = """\
rigrunner: procedure/2
id: SHORT
revision: "A"
title: One recording under load
uses: {tester: swing_tester}
main:
  - set: {tester.load: 100 N}
  - record: {channels: [tester.torque], duration: 0.05 s}
teardown:
  - set: {tester.load: 0 N}
"""
OF_DESCRIPTORS = ("write", "fsync", "ftruncate", "fstat", "close", "fchmod")
OF_PATHS = ("mkdir", "rename", "replace", "unlink", "stat", "chmod", "utime", "scandir", "listdir")
OF_FILES = ("write", "truncate", "close", "read", "readinto")
LASTING = {"write", "truncate", "open"}
"""On a full disk these fail from then on."""


class Failing:
    """Lets an operation on a file below some folders fail: its name, and that of the file."""

    def __init__(self, monkeypatch) -> None:
        self.folders: tuple[str, ...] = ()
        self.operation: tuple[str, str] | None = None
        self.seen: dict[tuple[str, str], None] = {}
        self.has_failed = False
        for name in ("open", *OF_DESCRIPTORS, *OF_PATHS):
            monkeypatch.setattr(os, name, self.checked(name, getattr(os, name)))
        open_file = self.checked("open", io.open)

        def open_checked(*what, **options):
            return File(open_file(*what, **options), self)

        for module in (io, builtins):
            monkeypatch.setattr(module, "open", open_checked)

    def checked(self, name, function, path=None):
        """Return a function that is checked before it is called."""

        def call(*what, **options):
            try:
                if what or path:
                    self.check(name, path or what[0])
            except OSError:
                if name == "close":  # the system closes a file even then
                    function(*what)
                raise
            return function(*what, **options)

        return call

    def check(self, name, place):
        """Note an operation, and raise an OSError if it is the one that is to fail."""
        if not self.folders:
            return
        path = Path(f"/proc/self/fd/{place}").readlink() if isinstance(place, int) else Path(place)
        if not str(path).startswith(self.folders):
            return
        operation = (name, re.sub(r"\d{6,}|SHORT|#.*", "", path.name))
        self.seen[operation] = None
        lasts = self.has_failed and name in LASTING and self.operation[0] in LASTING
        if lasts or (operation == self.operation and not self.has_failed):
            self.has_failed = True
            number = errno.ENOSPC if name in LASTING else errno.EIO
            raise OSError(number, os.strerror(number), str(path))


class File:
    """An open file whose operations are checked."""

    def __init__(self, file, failing) -> None:
        self.file = file
        self.failing = failing

    def __getattr__(self, name):
        function = getattr(self.file, name)
        is_checked = name in OF_FILES and not self.file.closed
        return self.failing.checked(name, function, self.file.name) if is_checked else function

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __iter__(self):
        return iter(self.file)


@pytest.fixture
def failing(monkeypatch):
    return Failing(monkeypatch)


@pytest.fixture
def attempt(tmp_path, monkeypatch, failing):
    """Return a function that runs the procedure, and returns its end or error and its events."""
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))
    monkeypatch.setattr("rigrunner.run.rig_lock.real_roles", lambda *_: ["tester"])
    procedure = tmp_path / "short.yaml"
    procedure.write_text(PROCEDURE, encoding="utf-8")
    station = station_file(tmp_path, ("safety:\n", "safety:\n  guardian: no\n"))

    def run(operation):
        for name in ("runs", "rigs"):
            shutil.rmtree(tmp_path / name, ignore_errors=True)
        planned = plan_run(procedure, station, registry(), SimulatedClock(START))
        events = []
        failing.operation, failing.has_failed = operation, False
        failing.folders = (str(tmp_path / "runs"), str(tmp_path / "rigs"))
        try:
            return execute(
                planned,
                runs=tmp_path / "runs",
                inputs={},
                partners={},
                answers=UnattendedAnswers(),
                stop=threading.Event(),
                listeners=[events.append],
            ), events
        except RigrunnerError as error:
            return error, events
        finally:
            failing.folders = ()

    return run


def objections(end, events, tmp_path):
    """Yield what is wrong after a run in which an operation failed."""
    error = end if isinstance(end, Exception) else end.error
    if error is not None and str(tmp_path) not in f"{error}{getattr(error, 'hint', '')}":
        yield f"names no path: {error!r}"
    if end is not error and end.exit_code is ExitCode.BUG:
        yield f"a bug: {error!r}"
    if not any(isinstance(event, RunStarted) for event in events):
        return
    safe = {event.what: event for event in events if isinstance(event, MadeSafe)}["tester"]
    if safe.problems or set(safe.read_back.values()) != {0.0}:
        yield f"not safe: {safe}"
    if not any(isinstance(event, RunEnded) for event in events):
        yield "its end is not reported"
    stored = read(end.folder)
    recordings = {recording.name for recording in (*stored.recordings, *stored.incomplete)}
    ended = {event.recording for event in events if isinstance(event, StepEnded)} - {""}
    if ended - recordings:
        yield f"lost: {ended - recordings}"
    if error is None and (stored.info.outcome, end.outcome) != (Outcome.COMPLETED,) * 2:
        yield f"stored as {stored.info.outcome}"


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_run_survives_the_failure_of_each_operation(tmp_path, failing, attempt):
    finished, _ = attempt(None)
    assert finished.exit_code is ExitCode.PASS
    operations = list(failing.seen)
    assert len(operations) > 40
    problems = {}
    for operation in operations:
        end, events = attempt(operation)
        if failing.has_failed and (problem := list(objections(end, events, tmp_path))):
            problems[operation] = problem
    # Without its file it has no sample; what follows is recorded.
    assert problems.pop(("open", ".samples")) == ["lost: {'001'}"]
    assert problems.pop(("write", ".samples")) == ["lost: {'001'}"]
    assert problems == {}
