"""Locks of a rig by the operating system, which end with their process."""

from __future__ import annotations

import json
import os
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

from filelock import FileLock, Timeout

from rigrunner.rig_state.folder import FOR_ALL, read_plain, write_plain

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

PATIENCE_S = 0.3
"""Waiting time: a program that only checks whether a rig is held holds it for a moment."""


@dataclass(frozen=True)
class Holder:
    """Who holds a lock, for messages to others."""

    station: str
    procedure: str
    process: int
    since: str


class Busy(Exception):  # noqa: N818  (a state; callers turn it into an error)
    """Another process holds a lock."""

    def __init__(self, lock: Path, holder: Holder | None) -> None:
        super().__init__(f"{lock} is held")
        self.lock = lock
        self.holder = holder
        """Who holds it; None if unknown."""


@contextmanager
def hold(locks: Iterable[Path], holder: Holder) -> Iterator[tuple[int, ...]]:
    """Hold all of these locks; raise Busy if another process holds one, OSError for other failures.

    Yields the descriptor of each, -1 for none, for `take_over` by a process that inherits them.
    """
    descriptors = []
    with ExitStack() as stack:
        for path in locks:
            lock = FileLock(path, timeout=PATIENCE_S, mode=FOR_ALL)
            try:
                lock.acquire()
            except Timeout as error:
                raise Busy(path, holder_of(path)) from error
            stack.callback(lock.release)
            descriptor = lock._context.lock_file_fd  # noqa: SLF001  (there is no public access)
            descriptors.append(-1 if descriptor is None else descriptor)
            stack.enter_context(_holder_stored(path, holder))
        yield tuple(descriptors)


@contextmanager
def take_over(descriptors: Iterable[int], locks: Iterable[Path], holder: Holder) -> Iterator[None]:
    """Hold locks with descriptors inherited from a dead process, until this process ends.

    An inherited lock is held as long as a process with it lives, so that no other can take it in
    between. One that was released is locked again; raises Busy if somebody else has it. POSIX only.
    """
    import fcntl  # noqa: PLC0415  (there is none on Windows)

    with ExitStack() as stack:
        for descriptor, path in zip(descriptors, locks, strict=True):
            if is_removed(descriptor):  # a lock without a name excludes no one
                stack.enter_context(hold([path], holder))
                continue
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                raise Busy(path, holder_of(path)) from error
            stack.enter_context(_holder_stored(path, holder))
        yield


def is_removed(descriptor: int) -> bool:
    """Return whether the file of a lock was removed; False for no descriptor."""
    try:
        return descriptor >= 0 and not os.fstat(descriptor).st_nlink
    except OSError:  # a network disk does not know the file any more
        return True


def touch(lock: Path, descriptor: int) -> None:
    """Mark the files of a held lock as used now. POSIX only."""
    with suppress(OSError):
        os.utime(descriptor)
    with suppress(OSError):
        os.utime(_holder_file(lock), follow_symlinks=False)


@contextmanager
def _holder_stored(path: Path, holder: Holder) -> Iterator[None]:
    """Store who holds a lock while it is held."""
    with suppress(OSError):  # it only names the holder; the lock holds the rig
        write_plain(_holder_file(path), json.dumps(asdict(holder)).encode())
    try:
        yield
    finally:
        with suppress(OSError):
            os.unlink(_holder_file(path))  # noqa: PTH108  (as fast as possible: the rig waits)


def is_held(lock: Path) -> bool:
    """Return whether a process holds a lock; False if unknown."""
    with suppress(OSError):
        try:
            if lock.is_file():  # FileLock would create it
                with FileLock(lock, timeout=0, mode=FOR_ALL):
                    pass
        except Timeout:  # it is an OSError as well
            return True
    return False


def holder_of(lock: Path) -> Holder | None:
    """Return the last stored holder of a lock; None if unknown."""
    try:
        return Holder(**json.loads(read_plain(_holder_file(lock))))
    except (OSError, ValueError, TypeError):
        return None


def _holder_file(lock: Path) -> Path:
    return lock.with_suffix(".json")
