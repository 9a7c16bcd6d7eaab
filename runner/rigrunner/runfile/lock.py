"""The lock of a run's folder: of the operating system, so a dead process does not keep it."""

from __future__ import annotations

from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from filelock import FileLock, Timeout

from rigrunner.api.errors import DataError
from rigrunner.runfile.durable import writing
from rigrunner.runfile.folder import RunFolder

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

PATIENCE_S = 1.0
"""How long to wait: a process that only checks whether the run is active holds it for a moment."""


@contextmanager
def run_lock(folder: Path) -> Iterator[None]:
    """Hold a run's folder while it is written; raise DataError if a process has it."""
    files = RunFolder(folder)
    lock = FileLock(files.lock, timeout=PATIENCE_S)
    with writing(files.lock):
        try:
            lock.acquire()
        except Timeout as error:  # it is an OSError as well
            raise DataError(
                f"{folder.name} is still running: another process writes to it",
                hint="wait for its end, or stop that process: it makes the rig safe first",
            ) from error
    try:
        yield
    finally:
        with suppress(OSError):  # on Windows a file that is open cannot be removed
            # A sealed run is never written again.
            if files.sealed_file.exists():
                files.lock.unlink()
        lock.release()


def is_in_progress(folder: Path) -> bool:
    """Return whether a process writes to a run's folder; False if that is unknown."""
    path = RunFolder(folder).lock
    if not path.exists():
        return False
    lock = FileLock(path, timeout=0)
    try:
        with lock:
            return False
    except Timeout:
        return True
    except OSError:
        return False
