"""Files that survive a power failure: synced before they get their name, their folder after."""

from __future__ import annotations

import errno
import os
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

READ_ONLY = 0o444
_PATIENCE_S = (0.05, 0.1, 0.2, 0.4, 0.8)
"""How long to wait, each time, for a file that another program has open."""
_REMEDIES = {
    errno.ENOSPC: "free some space on the disk",
    errno.EDQUOT: "free some space: your share of the disk is used up",
    errno.EFBIG: "free some space: the file must not grow any more",
    errno.EROFS: "the disk is read-only: mount it for writing",
    errno.EACCES: "no permission to write there: ask for it, or choose another --runs",
    errno.EPERM: "no permission to write there: ask for it, or choose another --runs",
    errno.ENOENT: "the folder is gone: was it deleted or moved, or its disk taken away?",
    errno.ENOTDIR: "a file is where a folder is needed: choose another --runs",
    errno.EIO: "the disk does not answer: was it taken away, or is it broken?",
    errno.ENODEV: "the disk is gone: was it taken away?",
    errno.EBUSY: "another program holds the file: close it there",
}
"""How to fix a file that cannot be written, by the error number of the system."""


def temporary(path: Path) -> Path:
    """Return the name under which a file is written before it gets its own."""
    return path.with_name(path.name + ".tmp")


def publish(path: Path, *, read_only: bool) -> None:
    """Sync the temporary file of `path` and rename it, durably."""
    sync_file(temporary(path))
    # Before it has its name: it is never found writable.
    if read_only:
        temporary(path).chmod(READ_ONLY)
    _rename(temporary(path), path)
    sync_folder(path.parent)


def _rename(source: Path, target: Path) -> None:
    """Rename a file. On Windows a program such as a virus scanner may block it for a moment."""
    for pause_s in _PATIENCE_S if os.name == "nt" else ():
        try:
            source.replace(target)
        except PermissionError:
            time.sleep(pause_s)
        else:
            return
    source.replace(target)


def sync_file(path: Path) -> None:
    """Wait until the content of a file is on the disk."""
    # Not read-only: Windows syncs only what may be written.
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def sync_folder(path: Path) -> None:
    """Wait until the names in a folder are on the disk (Windows does this by itself)."""
    if os.name == "nt":
        return
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn an OSError into a DataError that names the file and how to fix it."""
    try:
        yield
    except OSError as error:
        raise cannot_write(path, error) from error


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn an OSError into a DataError that names the file."""
    try:
        yield
    except OSError as error:
        raise DataError(f"cannot read {path}: {error.strerror or error}") from error


def write_whole(path: Path, content: bytes) -> None:
    """Replace a file by a complete new one, or leave everything unchanged; raise DataError.

    A target that is no regular file, such as a pipe, is written directly.
    """
    with writing(path):
        if path.exists() and not path.is_file():
            path.write_bytes(content)
            return
        try:
            temporary(path).unlink(missing_ok=True)
            temporary(path).touch(exist_ok=False)  # a link that was put there is not followed
            temporary(path).write_bytes(content)
            publish(path, read_only=False)
        except BaseException:  # Ctrl-C too
            temporary(path).unlink(missing_ok=True)
            raise


def cannot_write(path: Path, error: OSError) -> DataError:
    """Return the error that names the file and how to fix it."""
    remedy = _REMEDIES.get(error.errno or 0, "is the disk full, gone or read-only?")
    hint = f"what was recorded before is kept; {remedy}"
    return DataError(f"cannot write {path}: {error.strerror or error}", hint=hint)
