"""The folder of locks and markers that everyone on this machine shares, and that outlives a boot.

Others can write there too: no link is followed, and nothing but a plain file is opened.
"""

from __future__ import annotations

import os
import stat
import sys
from contextlib import suppress
from pathlib import Path

from rigrunner.api.errors import DeviceError

VARIABLE = "RIGRUNNER_LOCKS"
"""Names the folder, such as one that several containers share, in place of the usual one."""
FOLDER = "rigrunner-rigs"
EVERYONE = 0o1777
"""Of the folder: everyone makes files in it, and nobody removes those of others (sticky)."""
FOR_ALL = 0o666
"""Of its files: the next run may be another person's, and has to open them."""
_UNFOLLOWED = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
"""Somebody may have put a link there, or a pipe that nobody reads."""
_BINARY = getattr(os, "O_BINARY", 0)
"""Without it Windows changes what looks like the end of a line."""


def shared_folder() -> Path:
    """Return the folder, made if it is missing; raise DeviceError if it cannot be used."""
    folder = _place()
    try:
        folder.mkdir(exist_ok=True)
        if sys.platform != "win32":  # there the folder above it says who may do what
            _open_to_all(folder)
    except OSError as error:
        raise DeviceError(
            f"the rig cannot be locked: {folder} is no folder for locks: {error.strerror}",
            hint=f"remove what is in its place, or name another folder in {VARIABLE}",
        ) from error
    return folder


def existing_folder() -> Path | None:
    """Return the folder if it is there."""
    folder = _place()
    return folder if folder.is_dir() and not folder.is_symlink() else None


def open_plain(path: Path, flags: int) -> int:
    """Return a descriptor of a file, made for everyone if it is missing and `flags` has O_CREAT.

    Raises OSError for a link, or a file with a second name: writing to it would change another
    one. An existing file is not opened with O_CREAT: in such folders Linux refuses it to others.
    """
    create, flags = flags & os.O_CREAT, flags & ~os.O_CREAT | _UNFOLLOWED | _BINARY
    try:
        opened = os.open(path, flags)
    except FileNotFoundError:
        if not create:
            raise
        opened = os.open(path, flags | os.O_CREAT | os.O_EXCL, FOR_ALL)
        with suppress(AttributeError, OSError):  # Windows has it not
            os.fchmod(opened, FOR_ALL)
    known = os.fstat(opened)
    if not stat.S_ISREG(known.st_mode) or known.st_nlink > 1:
        os.close(opened)
        raise OSError(f"{path} is a link, or no file")
    return opened


def read_plain(path: Path) -> bytes:
    """Return the content of a file, of at most 1 MB; raise OSError as `open_plain`."""
    with os.fdopen(open_plain(path, os.O_RDONLY), "rb") as file:
        return file.read(1_000_000)


def write_plain(path: Path, content: bytes) -> None:
    """Write a file whole, without waiting for the disk; raise OSError as `open_plain`."""
    with os.fdopen(open_plain(path, os.O_WRONLY | os.O_CREAT), "wb") as file:
        file.truncate()
        file.write(content)


def sync_names(folder: Path) -> None:
    """Wait until the names of files in a folder are on the disk (Windows does so by itself)."""
    if os.name == "nt":
        return
    opened = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


def _place() -> Path:
    named = os.environ.get(VARIABLE)
    return Path(named) if named else _for_everyone() / FOLDER


def _for_everyone() -> Path:
    """Return where all may write, and what is kept when the machine starts again.

    The folder for temporary files may be one person's own: it is on Windows and macOS, and where
    TMPDIR says so; two persons would hold two locks.
    """
    if sys.platform == "win32":
        return Path(os.environ.get("PUBLIC", "C:/Users/Public"))
    return Path("/var/tmp")  # noqa: S108  (everyone's is what is wanted)


def _open_to_all(folder: Path) -> None:
    """Let everyone make files in a folder; whoever put a link there gains nothing by it."""
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        with suppress(PermissionError):  # another person made it, and opened it to all
            os.fchmod(opened, EVERYONE)
    finally:
        os.close(opened)
