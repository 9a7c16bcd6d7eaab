"""The folder of locks and markers, shared by all users of this machine and kept over reboots.

Others can write there too: links are not followed, and only plain files are opened.
"""

from __future__ import annotations

import os
import stat
import sys
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from rigrunner.api.errors import DeviceError

if TYPE_CHECKING:
    from collections.abc import Iterator

VARIABLE = "RIGRUNNER_LOCKS"
"""Names another folder, such as one shared by several containers."""
FOLDER = "rigrunner-rigs"
EVERYONE = 0o1777
"""Mode of the folder: everyone can create files, and remove only their own (sticky)."""
FOR_ALL = 0o666
"""Mode of its files: the next run may be another user's, and must open them."""
_UNFOLLOWED = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
"""Somebody may have put a link there, or a pipe without a reader."""
_BINARY = getattr(os, "O_BINARY", 0)
"""Without it Windows changes line ends."""


def shared_folder() -> Path:
    """Return the folder, created if missing; raise DeviceError if it cannot be used."""
    folder = folder_path()
    with usable(folder):
        folder.mkdir(exist_ok=True)
        if sys.platform != "win32":  # there the parent folder determines the permissions
            _open_to_all(folder)
    return folder


def existing_folder() -> Path | None:
    """Return the folder if it exists; raise DeviceError if it cannot be used."""
    folder = folder_path()
    with usable(folder):
        return folder if folder.is_dir() and not folder.is_symlink() else None


@contextmanager
def usable(folder: Path) -> Iterator[None]:
    """Turn an OSError into a DeviceError that names the folder."""
    try:
        yield
    except OSError as error:
        raise DeviceError(
            f"the rig cannot be locked: {folder} is not a folder for locks: {error.strerror}",
            hint=f"remove what is in its place, or name another folder in {VARIABLE}",
        ) from error


def open_plain(path: Path, flags: int) -> int:
    """Return a descriptor of a file, created for everyone if missing and `flags` has O_CREAT.

    Raises OSError for a link, or a file with a second name, since writing would change another one.
    An existing file is not opened with O_CREAT, which Linux refuses to others in such folders.
    """
    create, flags = flags & os.O_CREAT, flags & ~os.O_CREAT | _UNFOLLOWED | _BINARY
    try:
        descriptor = os.open(path, flags)
    except FileNotFoundError:
        if not create:
            raise
        descriptor = os.open(path, flags | os.O_CREAT | os.O_EXCL, FOR_ALL)
        # The umask removed permissions that others need.
        with suppress(AttributeError, OSError):  # not on Windows
            os.fchmod(descriptor, FOR_ALL)
    status = os.fstat(descriptor)
    if not stat.S_ISREG(status.st_mode) or status.st_nlink > 1:
        os.close(descriptor)
        raise OSError(f"{path} is a link, or no file")
    return descriptor


def read_plain(path: Path) -> bytes:
    """Return the content of a file, at most 1 MB; raise OSError as `open_plain`."""
    with os.fdopen(open_plain(path, os.O_RDONLY), "rb") as file:
        return file.read(1_000_000)


def write_plain(path: Path, content: bytes) -> None:
    """Write a whole file without waiting for the disk; raise OSError as `open_plain`."""
    with os.fdopen(open_plain(path, os.O_WRONLY | os.O_CREAT), "wb") as file:
        file.truncate()
        file.write(content)


def sync_names(folder: Path) -> None:
    """Wait until the names of files in a folder are on the disk (Windows does so itself)."""
    if os.name == "nt":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def folder_path() -> Path:
    """Return the folder in the variable, or one that all can write to and that survives a reboot.

    The folder for temporary files can belong to one user: on Windows and macOS, and by TMPDIR. Two
    users would then hold two locks.
    """
    if path := os.environ.get(VARIABLE):
        return Path(path)
    if sys.platform == "win32":
        return Path(os.environ.get("PUBLIC", "C:/Users/Public")) / FOLDER
    return Path("/var/tmp") / FOLDER  # noqa: S108  (a folder of all users is intended)


def _open_to_all(folder: Path) -> None:
    """Let everyone create files in a folder; a link in its place is not followed."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        with suppress(PermissionError):  # another person made it, and opened it to all
            os.fchmod(descriptor, EVERYONE)
    finally:
        os.close(descriptor)
