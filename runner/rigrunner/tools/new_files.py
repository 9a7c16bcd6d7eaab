"""Write a set of new files, all or none, and never over an existing one."""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


def write_new_files(folder: Path, texts: Mapping[str, str]) -> list[str]:
    """Write texts by name into a folder, which is created if needed; return the names.

    Raises UsageError if a file of such a name exists, before any is written, and if one cannot be
    written.
    """
    existing = [name for name in texts if (folder / name).exists()]
    if existing:
        first, *others = existing
        more = f", and {len(others)} more of the files to write" if others else ""
        raise UsageError(
            f"{folder} has a {first} already{more}",
            hint="nothing was written, as files are never overwritten; name a new folder",
        )
    created: list[Path] = []
    try:
        for name, text in texts.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("x", encoding="utf-8", newline="\n") as file:
                created.append(path)
                file.write(text)
    except OSError as error:
        for path in created:
            path.unlink(missing_ok=True)
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        raise UsageError(
            f"cannot write {error.filename or folder}: {error.strerror or error}",
            hint="free some space on the disk" if full else "name a folder with write permission",
        ) from error
    return list(texts)
