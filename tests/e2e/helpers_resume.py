"""Runs as a kill leaves them: copies of the folder at some instant of a run."""

from __future__ import annotations

import shutil
import threading
from typing import TYPE_CHECKING

from helpers_workflow import quick_procedure, registry, run
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers
from rigrunner.run.interrupted import read_interrupted
from rigrunner.run.prepare import plan_run
from rigrunner.run.resume import prepare_resume, resume, run_files
from rigrunner.runfile import run_lock

if TYPE_CHECKING:
    from pathlib import Path

NO_LOAD = "no_load_inertia_sweep"
FEWER = ("cycles: 12}", "cycles: 10}")


class Snapshot:
    """Copies the folder of a run at an event, once: what a kill would leave."""

    def __init__(self, runs: Path, target: Path, at) -> None:
        self.runs = runs
        self.target = target
        self.at = at
        self.folder: Path | None = None

    def __call__(self, event) -> None:
        if self.folder is None and self.at(event):
            (source,) = (path for path in self.runs.iterdir() if not (path / "run.h5").exists())
            self.folder = self.target / source.name
            shutil.copytree(source, self.folder, ignore=shutil.ignore_patterns("run.lock"))


def interrupted(tmp_path, at, *, station=None, changes=(), procedure=None):
    """Return the folder of a run as it was at the first event for which `at` holds, and the run.

    The procedure is the quick no-load sweep with changes, unless another one is given.
    """
    options = {"station": station, "changes": changes, "procedure": procedure}
    (folder,), finished = interrupted_at(tmp_path, [at], **options)
    return folder, finished


def interrupted_at(tmp_path, instants, *, station=None, changes=(), procedure=None):
    """Return the folder of one run as it was at each of several instants, and the run."""
    snapshots = [
        Snapshot(tmp_path / "runs", tmp_path / f"killed{number}", at)
        for number, at in enumerate(instants)
    ]
    procedure = procedure or quick_procedure(tmp_path, NO_LOAD, FEWER, *changes)
    finished = run(procedure, tmp_path / "runs", station=station, listeners=snapshots)
    assert all(snapshot.folder is not None for snapshot in snapshots)
    return [snapshot.folder for snapshot in snapshots], finished


def resumable(folder, by="A. Jones", *, procedure=None, station=None):
    stored = read_interrupted(folder)
    files = run_files(stored, procedure, station)
    planned = plan_run(*files, registry(), SimulatedClock())
    return prepare_resume(folder, stored, planned, by)


def resume_run(folder, by="A. Jones", *, listeners=(), stop=None):
    with run_lock(folder):
        return resume(
            resumable(folder, by),
            answers=UnattendedAnswers(),
            stop=stop or threading.Event(),
            listeners=listeners,
        )
