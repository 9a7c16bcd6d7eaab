"""How fast files are read, so that others can work on the same disk."""

from __future__ import annotations

import time
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

BLOCK = 1 << 18
"""In bytes; so much may be read at once."""


@dataclass
class Pace:
    """Waits so that no more is read than so many bytes a second; idle time is not made up for."""

    bytes_per_s: float = inf
    now: Callable[[], float] = time.monotonic
    sleep: Callable[[float], None] = time.sleep
    _due_s: float = -inf

    def take(self, size: int) -> None:
        """Wait until so many bytes that were read are within the rate."""
        now = self.now()
        self._due_s = max(self._due_s, now) + size / self.bytes_per_s
        if self._due_s > now:
            self.sleep(self._due_s - now)
