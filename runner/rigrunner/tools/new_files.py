"""Write a set of new files, all or none, and never over an existing one."""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


def write_new_files(folder: Path, texts: Mapping[str, str]) -> None:
    """Write texts by name into a folder, which is created if needed.

    Raises UsageError if a file of such a name exists, before any is written, and if one cannot be
    written.
    """
    there = [name for name in texts if (folder / name).exists()]
    if there:
        others = f", and {len(there) - 1} more of the files to write" if len(there) > 1 else ""
        raise UsageError(
            f"{folder} has a {there[0]} already{others}",
            hint="nothing was written, as files are never overwritten; name a new folder",
        )
    begun: list[Path] = []
    try:
        for name, text in texts.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("x", encoding="utf-8", newline="\n") as file:
                begun.append(path)
                file.write(text)
    except OSError as error:
        for path in begun:
            path.unlink(missing_ok=True)
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        raise UsageError(
            f"cannot write {error.filename or folder}: {error.strerror or error}",
            hint="free some space on the disk" if full else "name a folder with write permission",
        ) from error
