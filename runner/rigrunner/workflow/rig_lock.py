"""One run at a time on a rig: a lock of the operating system, which no dead process holds."""

from __future__ import annotations

import json
import os
import tempfile
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from filelock import FileLock, Timeout

from rigrunner.api.errors import DeviceError
from rigrunner.clock import utc_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.workflow.prepare import Planned

FOLDER = "rigrunner-rigs"
EVERYONE = 0o777
"""The next run may be another person's; a lock that only its maker could open would stand in it."""


@contextmanager
def rig_lock(planned: Planned) -> Iterator[None]:
    """Hold the station's rig for this process; raise DeviceError where another one has it.

    The station's id names the rig, for everyone on this machine. A station of simulators alone is
    not locked: each process simulates a rig of its own.
    """
    if _simulated(planned):
        yield
        return
    lock_file = lock_folder() / f"{planned.station.model.id}.lock"
    lock = FileLock(lock_file, timeout=0, mode=0o666)
    try:
        lock.acquire()
    except Timeout as error:
        raise DeviceError(
            f"the rig of station {planned.station.model.id} is in use{_holder_text(lock_file)}",
            hint="wait for that run, or stop it; two rigs need two station ids",
        ) from error
    except OSError as error:
        raise DeviceError(f"the rig cannot be locked: {error}", hint=f"see {lock_file}") from error
    try:
        _write_holder(lock_file, planned)
        yield
    finally:
        _holder(lock_file).unlink(missing_ok=True)
        lock.release()


def lock_folder() -> Path:
    """Return the folder of locks that everyone on this machine shares."""
    folder = Path(tempfile.gettempdir()) / FOLDER
    folder.mkdir(exist_ok=True)
    with suppress(PermissionError):  # another person made it, and opened it to all
        folder.chmod(EVERYONE)
    return folder


def _simulated(planned: Planned) -> bool:
    return all(
        planned.registry.is_simulated(each.plugin, each.settings)
        for each in planned.station.model.devices.values()
    )


def _holder(lock_file: Path) -> Path:
    return lock_file.with_suffix(".json")


def _write_holder(lock_file: Path, planned: Planned) -> None:
    content = {
        "process": os.getpid(),
        "procedure": planned.procedure.model.id,
        "since": utc_text(planned.clock.utc()),
    }
    _holder(lock_file).write_text(json.dumps(content), encoding="utf-8")


def _holder_text(lock_file: Path) -> str:
    """Return who holds the lock in words; '' where it cannot be told."""
    try:
        found = json.loads(_holder(lock_file).read_text(encoding="utf-8"))
        return f": {found['procedure']}, process {found['process']}, since {found['since']}"
    except (OSError, ValueError, KeyError, TypeError):
        return ""
