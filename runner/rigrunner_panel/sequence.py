"""What the panel is to start from the queue; after a restart nothing starts by itself."""

from __future__ import annotations

import threading
from contextlib import ExitStack
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Wanted:
    """An entry that starts once its preflight is done."""

    entry: int
    by: str
    stops: int
    """How often Stop had been pressed when it was asked for."""


@dataclass(eq=False)
class Sequence:
    """What was asked for, and the entry that is running. Steps are taken under the lock."""

    lock: threading.RLock = field(default_factory=threading.RLock)
    wanted: Wanted | None = None
    automatic_by: str = ""
    problem: str = ""
    entry: int | None = None
    """The entry whose run goes on."""
    held: ExitStack = field(default_factory=ExitStack)
    """Holds that entry's lock."""
    stops: int = 0
    seen_ns: int = -1
    """When the file was changed that is shown."""

    def stop(self) -> None:
        """Start nothing any more that was asked for before; waits for nothing."""
        self.stops += 1
        self.automatic_by = ""
        self.wanted = None
