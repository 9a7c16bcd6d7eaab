"""One run at a time on a rig: a lock of the operating system, which no dead process holds."""

from __future__ import annotations

import json
import os
import stat
import sys
from contextlib import contextmanager, nullcontext, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from filelock import FileLock, Timeout

from rigrunner.api.errors import DeviceError
from rigrunner.clock import utc_text

if TYPE_CHECKING:
    from collections.abc import Iterator
    from contextlib import AbstractContextManager

    from rigrunner.registry import Registry
    from rigrunner.station import LoadedStation
    from rigrunner.workflow.prepare import Planned

VARIABLE = "RIGRUNNER_LOCKS"
"""Names the folder of locks, such as one that several containers share, in place of the usual."""
FOLDER = "rigrunner-rigs"
EVERYONE = 0o1777
"""Of the folder: everyone makes locks in it, and nobody removes those of others (sticky)."""
FOR_ALL = 0o666
"""Of its files: the next run may be another person's, and has to open them."""
_UNFOLLOWED = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
"""Somebody may have put a link there, or a pipe that nobody reads."""


def rig_lock(planned: Planned) -> AbstractContextManager[None]:
    """Hold the rig of a planned run; no rig is touched where the run is a replay."""
    if planned.tape is not None and planned.tape.replays:
        return nullcontext()
    return station_lock(planned.station, planned.registry, planned.procedure.model.id)


@contextmanager
def station_lock(station: LoadedStation, registry: Registry, what: str) -> Iterator[None]:
    """Hold the station's rig for this process; raise DeviceError where another one has it.

    The station's id names the rig, for everyone on this machine, and `what` says what it is held
    for. A station of simulators alone is not locked: each process simulates a rig of its own.
    """
    if _simulated(station, registry):
        yield
        return
    lock_file = lock_folder() / f"{station.model.id}.lock"
    lock = FileLock(lock_file, timeout=0, mode=FOR_ALL)
    try:
        lock.acquire()
    except Timeout as error:
        raise DeviceError(
            f"the rig of station {station.model.id} is in use{_holder_text(lock_file)}",
            hint="wait for that run, or stop it; two rigs need two station ids",
        ) from error
    except OSError as error:
        raise DeviceError(f"the rig cannot be locked: {error}", hint=f"see {lock_file}") from error
    try:
        _write_holder(lock_file, what)
        yield
    finally:
        with suppress(OSError):
            _holder(lock_file).unlink()
        lock.release()


def lock_folder() -> Path:
    """Return the folder of locks that everyone on this machine shares.

    Raises DeviceError where a link or a file stands in its place.
    """
    named = os.environ.get(VARIABLE)
    folder = Path(named) if named else _everyones() / FOLDER
    try:
        folder.mkdir(exist_ok=True)
        if sys.platform != "win32":  # there the folder above it says who may do what
            _open_to_all(folder)
    except OSError as error:
        raise DeviceError(
            f"the rig cannot be locked: {folder} is no folder for locks: {error.strerror}",
            hint="remove what stands there",
        ) from error
    return folder


def _everyones() -> Path:
    """Return where all may write: the folder for temporary files may be one person's own.

    It is on Windows and macOS, and where TMPDIR says so; two persons would hold two locks.
    """
    if sys.platform == "win32":
        return Path(os.environ.get("PUBLIC", "C:/Users/Public"))
    return Path("/tmp")  # noqa: S108  (everyone's is what is wanted)


def _open_to_all(folder: Path) -> None:
    """Let everyone make locks in a folder; whoever put a link there gains nothing by it."""
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        with suppress(PermissionError):  # another person made it, and opened it to all
            os.fchmod(opened, EVERYONE)
    finally:
        os.close(opened)


def _simulated(station: LoadedStation, registry: Registry) -> bool:
    devices = station.model.devices.values()
    return all(registry.is_simulated(each.plugin, each.settings) for each in devices)


def _holder(lock_file: Path) -> Path:
    return lock_file.with_suffix(".json")


def _write_holder(lock_file: Path, what: str) -> None:
    content = {
        "process": os.getpid(),
        "procedure": what,
        "since": utc_text(datetime.now(UTC)),
    }
    with suppress(OSError):  # it tells who holds the rig; what holds it is the lock
        _write_plain(_holder(lock_file), json.dumps(content).encode())


def _write_plain(path: Path, content: bytes) -> None:
    """Write a file in a folder where others write too; raise OSError for what is no file of ours.

    That is a link, or a file with a second name: writing to it would change another one. An
    existing file is not opened as one to be made: in such folders Linux refuses it to others.
    """
    flags = os.O_WRONLY | _UNFOLLOWED
    try:
        opened = os.open(path, flags | os.O_CREAT | os.O_EXCL, FOR_ALL)
        with suppress(AttributeError):  # Windows has it not
            os.fchmod(opened, FOR_ALL)
    except FileExistsError:
        opened = os.open(path, flags)
    with os.fdopen(opened, "wb") as file:
        known = os.fstat(file.fileno())
        if not stat.S_ISREG(known.st_mode) or known.st_nlink > 1:
            raise OSError(f"{path} is a link")
        file.truncate()
        file.write(content)


def _holder_text(lock_file: Path) -> str:
    """Return who holds the lock in words; '' where it cannot be told."""
    try:
        found = json.loads(_holder(lock_file).read_text(encoding="utf-8"))
        return f": {found['procedure']}, process {found['process']}, since {found['since']}"
    except (OSError, ValueError, KeyError, TypeError):
        return ""
