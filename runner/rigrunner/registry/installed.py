"""Which providers of plugins are installed: found in all distributions, and remembered.

To find them the entry points of every installed distribution are read, and most have none for us.
What was found is kept beside the compiled form of this module, as trusted and as easily made anew
as that, and holds for as long as none of the files that were read has changed.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import time
from contextlib import suppress
from dataclasses import asdict, dataclass
from importlib.machinery import PathFinder
from importlib.metadata import EntryPoint, entry_points
from importlib.util import cache_from_source
from pathlib import Path
from typing import TYPE_CHECKING

from rigrunner.api.hooks import PROJECT

if TYPE_CHECKING:
    from collections.abc import Iterator

RACY_S = 2.0
"""A file may change twice within one tick of the clock of its file system; FAT ticks slowest."""
_READ = {
    ".dist-info": ("entry_points.txt", "METADATA"),
    ".egg-info": ("entry_points.txt", "PKG-INFO"),
}
"""What is read of a distribution, by the ending of its folder."""


@dataclass(frozen=True)
class Installed:
    """A provider of plugins."""

    name: str
    place: str
    """The module that has its hooks, as an entry point gives it."""
    version: str
    """Of its distribution; '' for none."""

    @classmethod
    def of(cls, entry: EntryPoint) -> Installed:
        """Return the provider that an entry point gives."""
        return cls(entry.name, entry.value, entry.dist.version if entry.dist else "")

    @property
    def entry(self) -> EntryPoint:
        """What imports it."""
        return EntryPoint(self.name, self.place, PROJECT)


def installed() -> tuple[Installed, ...]:
    """Return all providers that are installed, by name."""
    files = _files_read()
    if files is None:
        return _found()
    key = hashlib.sha256(repr(files).encode()).hexdigest()
    remembered = _remembered(key)
    if remembered is not None:
        return remembered
    found = _found()
    if max((each[1] for each in files), default=0) < (time.time() - RACY_S) * 1e9:
        _remember(key, found)
    return found


def _found() -> tuple[Installed, ...]:
    entries = sorted(entry_points(group=PROJECT), key=lambda entry: entry.name)
    return tuple(Installed.of(entry) for entry in entries)


def _files_read() -> list[tuple[str, int, int]] | None:
    """Return path, time of change in ns and size of every file that may matter.

    None where something else than folders is searched, of which a look at files says nothing.
    """
    finders = (each for each in sys.meta_path if hasattr(each, "find_distributions"))
    if any(each is not PathFinder for each in finders):
        return None
    files: list[tuple[str, int, int]] = [(sys.version, 0, 0)]
    for folder in dict.fromkeys(path or "." for path in sys.path):
        if not os.path.isdir(folder):  # noqa: PTH112  (a Path for each would take longer than to look)
            if os.path.exists(folder):  # noqa: PTH110  (as above)
                return None  # an archive
            continue
        if folder.endswith(".egg"):
            return None
        files += _of_folder(os.path.abspath(folder))  # noqa: PTH100  (as above)
    return files


def _of_folder(folder: str) -> Iterator[tuple[str, int, int]]:
    try:
        names = sorted(os.listdir(folder))  # noqa: PTH208  (as above)
    except OSError:
        return
    for name in names:
        for read in _READ.get(os.path.splitext(name)[1], ()):  # noqa: PTH122  (as above)
            path = f"{folder}/{name}/{read}"
            try:
                found = os.stat(path)  # noqa: PTH116  (as above)
            except OSError:
                yield path, 0, -1
            else:
                yield path, found.st_mtime_ns, found.st_size


def _memory() -> Path:
    return Path(cache_from_source(__file__)).with_suffix(".json")


def _remembered(key: str) -> tuple[Installed, ...] | None:
    """Return what is kept for that key; None for anything that is not of that form."""
    try:
        kept = json.loads(_memory().read_bytes())
        if kept["key"] != key:
            return None
        found = tuple(Installed(**each) for each in kept["installed"])
    except (OSError, ValueError, TypeError, KeyError, RecursionError, NotImplementedError):
        return None
    texts = (text for each in found for text in (each.name, each.place, each.version))
    return found if all(isinstance(text, str) for text in texts) else None


def _remember(key: str, found: tuple[Installed, ...]) -> None:
    """Keep what was found, unless it cannot be: then it is looked for again the next time."""
    if sys.dont_write_bytecode:
        return
    content = {"key": key, "installed": [asdict(each) for each in found]}
    with suppress(OSError, NotImplementedError):
        memory = _memory()
        memory.parent.mkdir(exist_ok=True, parents=True)
        part = memory.with_suffix(f".{os.getpid()}.part")
        part.write_text(json.dumps(content), encoding="utf-8")
        part.replace(memory)
