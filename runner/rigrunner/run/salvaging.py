"""Salvages a damaged run into a new file, which states what is lost."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError, UsageError
from rigrunner.api.events import Intervention, Outcome, RunEnded
from rigrunner.bus import EventStamp
from rigrunner.clock import utc_text
from rigrunner.runfile import read_damaged, sealed_file_of, write_salvaged
from rigrunner.runfile.durable import temporary, writing
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.manifest import place

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.api.devices import Clock
    from rigrunner.runfile import DamagedRun

SALVAGE = "salvage"
"""The intervention that salvages a damaged run."""
MARK = "salvaged"
"""Suffix of the name of the new run."""


def damaged_run(path: Path) -> DamagedRun:
    """Return the intact part of a sealed run; raise DataError if there is none."""
    sealed = sealed_file_of(path)
    if sealed is None:
        raise DataError(
            f"{path} is not sealed: there is no file to be damaged",
            hint="'rigrunner recover' closes a run that was interrupted",
        )
    return read_damaged(sealed)


def salvage(path: Path, clock: Clock, by: str, reason: str = "") -> Path:
    """Salvage a damaged run into a folder beside it, and return that folder.

    The damaged file is not changed. The new run ends in an error and is never certified. Raises
    UsageError if nothing is damaged or the folder exists, and DataError if nothing can be salvaged.
    """
    damaged = damaged_run(path)
    if not damaged.lost:
        raise UsageError(
            f"{damaged.path} is sound: there is nothing to salvage",
            hint=f"'rigrunner show {damaged.header.run_id}' shows what is in it",
        )
    if not damaged.sound:
        raise DataError(
            f"{damaged.path} holds no sound recording", hint="restore it from a copy or a backup"
        )
    folder = damaged.path.absolute().parent
    target = folder.with_name(f"{folder.name}_{MARK}")
    if target.exists():
        raise UsageError(f"{target} exists", hint="what was salvaged is never overwritten")
    header = replace(
        damaged.header,
        run_id=target.name,
        salvaged={
            "file": f"{folder.name}/{damaged.path.name}",
            "sha256": damaged.sha256,
            "run": damaged.header.run_id,
            "utc": utc_text(clock.utc()),
            "by": by,
            **{f"lost {place(loss.path)}": f"{loss.kind}: {loss.what}" for loss in damaged.lost},
        },
    )
    stamp = EventStamp(clock, max((event.seq for event in damaged.events), default=-1) + 1)
    end = f"salvaged from {damaged.path.name}, which is damaged: {lost_text(damaged)}"
    events = (
        *damaged.events,
        stamp(Intervention, action=SALVAGE, by=by, reason=reason),
        stamp(RunEnded, outcome=Outcome.ERROR, reason=end),
    )
    with writing(target):
        target.mkdir()
    sealed = RunFolder(target).sealed_file
    try:
        write_salvaged(damaged, header, events, sealed)
    except BaseException:
        # Not the folder with all that is in it: a Ctrl-C may come once the file has its name.
        with suppress(OSError):
            temporary(sealed).unlink(missing_ok=True)
            target.rmdir()
        raise
    return target


def lost_text(damaged: DamagedRun) -> str:
    """Return how much is lost and how much is intact, as text."""
    objects = "1 object is" if len(damaged.lost) == 1 else f"{len(damaged.lost)} objects are"
    count = len(damaged.sound)
    return f"{objects} lost, {count} recording{' is' if count == 1 else 's are'} sound"
