"""What a program holds and accesses: threads, open files and sockets."""

from __future__ import annotations

import gc
import os
import sys
import threading
import time
from collections import Counter
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Generator

PATIENCE_S = 2.0
"""How long a thread that is ending may take."""
HANDLES = (Path("/proc/self/fd"), Path("/dev/fd"))
TOUCHING = (
    "socket.connect",
    "socket.bind",
    "socket.sendto",
    "socket.getaddrinfo",  # without a network, all that is seen of a connection
    "subprocess.Popen",
    "os.system",
)
"""Audit events of access to sockets and processes (docs.python.org, audit_events)."""


@dataclass(frozen=True)
class Census:
    """Threads by name, and the target of each open handle."""

    threads: Counter[str]
    handles: Counter[str]

    def more_than(self, before: Census) -> str:
        """Return the additional threads and handles, as text."""
        additional = [f"thread '{name}'" for name in (self.threads - before.threads).elements()]
        additional += list((self.handles - before.handles).elements())
        return ", ".join(additional)


def leaks_since(before: Census) -> str:
    """Return, as text, what the program still holds beyond that after the end of threads."""
    until_s = time.monotonic() + PATIENCE_S
    while (leaks := census().more_than(before)) and time.monotonic() < until_s:
        time.sleep(0.05)
    return leaks


def census() -> Census:
    """Return what the program holds, after garbage collection and the end of threads."""
    gc.collect()
    until_s = time.monotonic() + PATIENCE_S
    previous, current = None, _count()
    while current != previous and time.monotonic() < until_s:
        time.sleep(0.05)
        previous, current = current, _count()
    return current


def _count() -> Census:
    threads = Counter(thread.name for thread in threading.enumerate())
    return Census(threads, Counter(_handles()))


def _handles() -> list[str]:
    """Return the target of each open handle; nothing if the system does not tell."""
    folder = next((path for path in HANDLES if path.is_dir()), None)
    if folder is None:
        return []
    targets = []
    for name in os.listdir(folder):  # noqa: PTH208  (the iterator of Path holds a handle of its own)
        try:
            targets.append(os.readlink(folder / name))  # noqa: PTH115  (as above)
        except OSError:  # that of the listing itself
            continue
    return targets


_accesses: ContextVar[list[str] | None] = ContextVar("_accesses", default=None)


@contextmanager
def watch_accesses() -> Generator[list[str]]:
    """Collect the accesses of the block, in this thread."""
    _install()
    accesses: list[str] = []
    token = _accesses.set(accesses)
    try:
        yield accesses
    finally:
        _accesses.reset(token)


@cache
def _install() -> None:
    """Install an audit hook, once: it cannot be removed."""
    sys.addaudithook(_record_access)


def _record_access(event: str, arguments: tuple[object, ...]) -> None:
    accesses = _accesses.get()
    if accesses is None:
        return
    if event in TOUCHING:
        accesses.append(event)
    elif event == "open" and str(arguments[0]).startswith("/dev/"):
        accesses.append(f"open {arguments[0]}")
