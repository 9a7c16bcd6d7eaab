"""How many cycles each device has moved in: the frequency that was set, over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.devices import Clock


@dataclass
class _Count:
    done: float = 0.0
    frequency_hz: float = 0.0
    since_s: float | None = None
    """Since when it moves at that frequency; None while it is paused."""


class CycleCount:
    """Counts by role, of the drives that set the frequency of a cyclic motion.

    While a drive is on its way the mean of both frequencies counts.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._counts: dict[str, _Count] = {}

    def leave(self, role: str) -> None:
        """Take note that the drive of a role is about to be set."""
        count = self._counts.setdefault(role, _Count())
        self._bring_up(count)
        count.since_s = self._clock.monotonic_s()

    def stand(self, role: str, frequency_hz: float) -> None:
        """Take note that the drive of a role, once left, has come to a frequency."""
        count, now_s = self._counts.setdefault(role, _Count()), self._clock.monotonic_s()
        if count.since_s is not None:
            count.done += (now_s - count.since_s) * (count.frequency_hz + frequency_hz) / 2
        count.frequency_hz, count.since_s = frequency_hz, now_s

    def pause(self, role: str) -> None:
        """Count no more of a role until it goes on."""
        if count := self._counts.get(role):
            self._bring_up(count)
            count.since_s = None

    def resume(self, role: str) -> None:
        """Count again, at the same frequency."""
        if count := self._counts.get(role):
            count.since_s = self._clock.monotonic_s()

    def stop(self) -> None:
        """Take note that the whole rig is brought to rest."""
        for count in self._counts.values():
            self._bring_up(count)
            count.frequency_hz = 0.0

    def start_from(self, done: Mapping[str, float]) -> None:
        """Count from here on, and from these numbers by role; from 0 of any other."""
        for role, count in self._counts.items():
            self._bring_up(count)
            count.done = done.get(role, 0.0)
        for role in done.keys() - self._counts.keys():
            self._counts[role] = _Count(done[role])

    def done(self) -> dict[str, float]:
        """Return how many cycles each role has moved by now; nothing of one that never did."""
        for count in self._counts.values():
            self._bring_up(count)
        return {role: count.done for role, count in self._counts.items()}

    def _bring_up(self, count: _Count) -> None:
        now_s = self._clock.monotonic_s()
        if count.since_s is not None:
            count.done += (now_s - count.since_s) * count.frequency_hz
            count.since_s = now_s
