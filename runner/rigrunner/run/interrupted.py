"""Interrupted runs: reading them, and closing one as it is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.api.events import Intervention, Outcome, RunEnded
from rigrunner.bus import EventStamp
from rigrunner.runfile import RunWriter, end_of, read, run_lock, seal, sealed_file_of

if TYPE_CHECKING:
    from rigrunner.api.devices import Clock
    from rigrunner.runfile import RunHeader, StoredRun

FILES = ("procedure", "station")
"""Files named in a header besides partner runs."""
RECOVER = "recover"
"""The intervention that closes a run as it is."""


def read_interrupted(folder: Path) -> StoredRun:
    """Read a run that is not sealed; raise DataError for a sealed one."""
    if sealed_file_of(folder) is not None:
        name = folder.parent.name if folder.is_file() else folder.name
        raise DataError(
            f"{name} has ended and is sealed: there is nothing to resume or to save",
            hint=f"'rigrunner show {name}' shows what is in it",
        )
    return read(folder)


def has_ended(stored: StoredRun) -> bool:
    """Return whether a run has ended in any way without its file."""
    return end_of(stored.outline) is not None


def may_be_resumed(stored: StoredRun) -> bool:
    """Return whether a run can be resumed: it was interrupted, or could not be recorded."""
    end = end_of(stored.outline)
    return end is None or end.resumable


def person(stored: StoredRun) -> str:
    """Return who began a run."""
    header = stored.header
    return header.people.get("operator") or header.inputs.get("operator") or "operator"


def next_seq(stored: StoredRun) -> int:
    """Return the number of the next event of a run."""
    return max((event.seq for event in stored.events), default=-1) + 1


def used_partners(header: RunHeader) -> dict[str, Path]:
    """Return the chosen partner runs of a run, by name, if they still exist."""
    files = {name: Path(file) for name, file in header.files.items() if file}
    return {name: file for name, file in files.items() if name not in FILES and file.exists()}


def recover(folder: Path, clock: Clock, by: str, reason: str = "") -> StoredRun:
    """Close an interrupted run as it is, seal it, and return it; its rig is not touched.

    Its outcome is 'aborted', unless it had ended already. Raises DataError for a run that is sealed
    or still running, or if the folder is not writable.
    """
    with run_lock(folder):
        stored = read_interrupted(folder)
        if not has_ended(stored):
            stamp = EventStamp(clock, next_seq(stored))
            why = f": {reason}" if reason else ""
            text = f"interrupted, and closed as it was by {by}{why}"
            with RunWriter(folder) as writer:
                writer(stamp(Intervention, action=RECOVER, by=by, reason=reason))
                writer(stamp(RunEnded, outcome=Outcome.ABORTED, reason=text))
        seal(folder, partners=used_partners(stored.header))
        return read(folder)
