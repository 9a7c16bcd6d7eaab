"""Limit the rate of reading, so that others can use the same disk."""

from __future__ import annotations

import time
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

BLOCK = 1 << 18
"""The most bytes that are read at once."""


@dataclass
class Pace:
    """Waits so that the rate of reading stays below a limit; idle time does not count."""

    bytes_per_s: float = inf
    now: Callable[[], float] = time.monotonic
    sleep: Callable[[float], None] = time.sleep
    _due_s: float = -inf

    def take(self, size: int) -> None:
        """Wait until this many bytes are within the rate."""
        now = self.now()
        self._due_s = max(self._due_s, now) + size / self.bytes_per_s
        if self._due_s > now:
            self.sleep(self._due_s - now)
