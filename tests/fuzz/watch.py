"""Finds readers that write elsewhere, start programs or connect to other machines."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
CHANGES = {
    "os.chmod": 1, "os.link": 2, "os.mkdir": 1, "os.remove": 1, "os.rename": 2, "os.rmdir": 1,
    "os.symlink": 2, "os.truncate": 1,
}  # fmt: skip
"""Audit events of Python that change files, with the number of arguments that are paths."""
PROGRAMS = ("os.exec", "os.fork", "os.forkpty", "os.posix_spawn", "os.system", "subprocess.Popen")
PROBE = [sys.executable, "-P", "-c"]
"""The process that tries run files that may crash HDF5: rigrunner.runfile.probe."""
HERE = ("127.0.0.1", "::1", "localhost")


def watch(folder: Path) -> list[str]:
    """Record all later actions of this process beyond a folder."""
    inside, actions = os.path.realpath(folder) + os.sep, []

    def hook(event: str, values: tuple[Any, ...]) -> None:
        if event == "open":
            paths = values[:1] if values[2] & WRITING else ()
        else:
            paths = values[: CHANGES.get(event, 0)]
        names = [os.fsdecode(path) for path in paths if isinstance(path, str | bytes | os.PathLike)]
        actions.extend(f"{event} {name}" for name in names if _beyond(name, inside))
        is_program = event in PROGRAMS and list(*values[1:2])[:3] != PROBE
        if is_program or (event == "socket.connect" and _elsewhere(values[1])):
            actions.append(f"{event} {values[-1]}")

    sys.addaudithook(hook)
    return actions


def _beyond(path: str, inside: str) -> bool:
    """Return whether a path is outside; its last link is not followed, as it may be changed."""
    head, tail = os.path.split(path)
    return path != os.devnull and not f"{os.path.realpath(head)}{os.sep}{tail}".startswith(inside)


def _elsewhere(address: object) -> bool:
    return isinstance(address, tuple) and address[0] not in HERE
