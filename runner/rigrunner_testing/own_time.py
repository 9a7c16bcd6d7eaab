"""How long a call takes by itself, on a machine that also does other work."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

TRIES = 3
"""The shortest time of all counts: what a call waits for may itself have waited for others."""
BUSY = 3.0
"""Computing may be suspended for this much longer uncounted, for instance by a host machine."""


@dataclass(frozen=True)
class OwnTime:
    """The time of a call in this thread, less that for which others had the processor."""

    took_s: float
    waited_s: float
    """The part in which it did not compute."""


def measured(work: Callable[[], object]) -> OwnTime:
    """Return how long the call takes."""
    began_s, busy_s, suspended_s = time.monotonic(), time.thread_time(), _suspended_s()
    work()
    took_s = time.monotonic() - began_s - (_suspended_s() - suspended_s)
    return OwnTime(took_s, took_s - (1 + BUSY) * (time.thread_time() - busy_s))


def _suspended_s() -> float:
    """Return for how long this thread could run, but others did; 0 if the system does not count."""
    try:  # Linux, Documentation/scheduler/sched-stats: the second number, in nanoseconds
        return int(Path("/proc/thread-self/schedstat").read_bytes().split()[1]) / 1e9
    except (OSError, IndexError):
        return 0.0
