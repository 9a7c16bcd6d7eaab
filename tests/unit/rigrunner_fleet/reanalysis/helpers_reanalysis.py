"""Folders of stored runs, and a batch of analyses of them."""

from __future__ import annotations

import shutil
import threading
from dataclasses import replace

from rigrunner.jobs import InProcess
from rigrunner_fleet.reanalysis.batch import Batch
from rigrunner_fleet.reanalysis.changes import Changes
from rigrunner_fleet.reanalysis.selection import select_runs


def lab_of(folder, quick, copies=3):
    """Make a folder with runs of two rigs: a no-load run and copies of a loaded run."""
    shutil.copytree(quick.no_load, folder / "rig-1" / "no-load")
    for number in range(copies):
        rig = folder / f"rig-{1 + number % 2}"
        shutil.copytree(quick.loaded, rig / f"loaded-{number}")
    return folder


def batch(**changed):
    """Return a batch that runs in this process by default."""
    return replace(
        Batch(Changes(), None, InProcess(), threading.Event(), lambda *_: None), **changed
    )


def reanalysed(lab, out, **changed):
    return batch(**changed).run(select_runs([lab]), out)


def results(out):
    """Return the text of every result, by the name of its run."""
    paths = sorted(out.rglob("result.json"))
    return {path.parent.relative_to(out).as_posix(): path.read_text() for path in paths}
