"""List the run folders below a folder, and whether they changed, without opening a file."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

_SEALED = "run.h5"
_JOURNAL = "journal"


@dataclass(frozen=True)
class FoundFile:
    """A file of a run folder."""

    name: str
    bytes: int
    modified_ns: int


@dataclass(frozen=True)
class FoundRun:
    """A run folder."""

    path: str
    """From the root, with '/'; what is not Unicode in it is escaped."""
    folder: Path
    files: tuple[FoundFile, ...]

    @property
    def stamp(self) -> str:
        """A short text that changes with the name, size or time of any file.

        Empty for a run that is not sealed, which is read each time.
        """
        if not any(file.name == _SEALED for file in self.files):
            return ""
        listing = "\n".join(f"{file.name}\t{file.bytes}\t{file.modified_ns}" for file in self.files)
        return hashlib.sha256(listing.encode(errors="surrogateescape")).hexdigest()[:32]


def ignore(path: str, problem: str) -> None:
    """Ignore what cannot be read."""


def run_folders(root: Path, unread: Callable[[str, str], None] = ignore) -> Iterator[FoundRun]:
    """Yield the run folders below a root at any depth, in the order of their paths.

    Hidden folders and links are skipped, and so is what cannot be read: `unread` is called with its
    path and the reason.
    """
    yield from _below(root, "", unread)


def _below(folder: Path, prefix: str, unread: Callable[[str, str], None]) -> Iterator[FoundRun]:
    try:
        with os.scandir(folder) as listing:
            entries = sorted(listing, key=lambda entry: entry.name)
    except OSError as error:
        unread(storable(prefix[:-1]), f"the folder cannot be read: {error.strerror}")
        return
    names = {entry.name for entry in entries}
    if prefix and (_SEALED in names or _JOURNAL in names):
        yield FoundRun(storable(prefix[:-1]), folder, tuple(_files(entries)))
        return
    for entry in entries:
        if entry.is_dir(follow_symlinks=False) and not entry.name.startswith("."):
            yield from _below(folder / entry.name, f"{prefix}{entry.name}/", unread)


def _files(entries: list[os.DirEntry[str]]) -> Iterator[FoundFile]:
    for entry in entries:
        try:
            if entry.is_file(follow_symlinks=False):
                stat = entry.stat(follow_symlinks=False)
                yield FoundFile(entry.name, stat.st_size, stat.st_mtime_ns)
        except OSError:  # gone since it was listed
            continue


def storable(text: str) -> str:
    """Return a text that every database accepts: without NUL, invalid Unicode escaped."""
    return text.encode("utf-8", "backslashreplace").decode().replace("\0", "\\x00")
