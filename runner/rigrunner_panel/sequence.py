"""What the panel starts from the queue; after a restart nothing starts automatically."""

from __future__ import annotations

import threading
from contextlib import ExitStack
from dataclasses import dataclass, field


@dataclass(frozen=True)
class PendingStart:
    """A queue entry that starts when its preflight is done."""

    entry: int
    by: str
    stops: int
    """The count of Stop commands when the start was requested."""
    by_itself: bool = False
    """Whether it starts automatically, without a request."""


@dataclass(eq=False)
class Sequence:
    """The requested starts and the running entry. Change it only under the lock."""

    lock: threading.RLock = field(default_factory=threading.RLock)
    pending: PendingStart | None = None
    automatic_by: str = ""
    problem: str = ""
    entry: int | None = None
    """The entry whose run is in progress."""
    entry_lock: ExitStack = field(default_factory=ExitStack)
    """The lock of that entry."""
    stops: int = 0
    shown_version: object = None
    """The version of the displayed queue."""

    def stop(self) -> None:
        """Cancel all requested starts, without waiting."""
        self.stops += 1
        self.automatic_by = ""
        self.pending = None
