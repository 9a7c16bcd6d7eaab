"""What the instruments on loopback act on and measure: one drive's frequency, one press's load."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable


@dataclass(frozen=True)
class Ramp:
    """A quantity on its way to a target at a constant rate."""

    start: float
    target: float
    rate_per_s: float
    since_s: float

    def at(self, now_s: float) -> float:
        """Return where it is at that time."""
        distance = self.target - self.start
        travelled = min(self.rate_per_s * (now_s - self.since_s), abs(distance))
        return self.start + (travelled if distance > 0 else -travelled)


class Plant:
    """The true state of the rig behind the instruments, for any thread.

    The inverter and the press set where it is to go; whatever measures asks where it is.
    """

    def __init__(
        self,
        frequency_rate_hz_per_s: float = 20.0,
        load_rate_n_per_s: float = 1000.0,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._now_s = now_s
        self._lock = threading.Lock()
        self._frequency = Ramp(0.0, 0.0, frequency_rate_hz_per_s, now_s())
        self._load = Ramp(0.0, 0.0, load_rate_n_per_s, now_s())

    @property
    def frequency_hz(self) -> float:
        """How fast the motor turns now."""
        with self._lock:
            return self._frequency.at(self._now_s())

    @property
    def load_n(self) -> float:
        """How hard the press presses now."""
        with self._lock:
            return self._load.at(self._now_s())

    def go_to_frequency(self, frequency_hz: float) -> None:
        """Let the motor go to another frequency."""
        with self._lock:
            self._frequency = self._ramp_to(self._frequency, frequency_hz)

    def go_to_load(self, load_n: float) -> None:
        """Let the press go to another load."""
        with self._lock:
            self._load = self._ramp_to(self._load, load_n)

    def _ramp_to(self, ramp: Ramp, target: float) -> Ramp:
        now_s = self._now_s()
        return Ramp(ramp.at(now_s), target, ramp.rate_per_s, now_s)
