"""Number of cycles of each device: the integral of the set frequency over time."""

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
    """Start time at that frequency; None while paused."""


class CycleCount:
    """Counts cycles by role, for drives that set the frequency of a cyclic motion.

    While a drive moves, the mean of both frequencies counts.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._counts: dict[str, _Count] = {}

    def leave(self, role: str) -> None:
        """Note that the drive of a role is about to be set."""
        count = self._counts.setdefault(role, _Count())
        self._bring_up(count)
        count.since_s = self._clock.monotonic_s()

    def stand(self, role: str, frequency_hz: float) -> None:
        """Note that the drive of a role has reached a frequency."""
        count, now_s = self._counts.setdefault(role, _Count()), self._clock.monotonic_s()
        if count.since_s is not None:
            count.done += (now_s - count.since_s) * (count.frequency_hz + frequency_hz) / 2
        count.frequency_hz, count.since_s = frequency_hz, now_s

    def pause(self, role: str) -> None:
        """Stop counting for a role until it resumes."""
        if count := self._counts.get(role):
            self._bring_up(count)
            count.since_s = None

    def resume(self, role: str) -> None:
        """Resume counting at the same frequency."""
        if count := self._counts.get(role):
            count.since_s = self._clock.monotonic_s()

    def stop(self) -> None:
        """Note that the whole rig was stopped."""
        for count in self._counts.values():
            self._bring_up(count)
            count.frequency_hz = 0.0

    def start_from(self, done: Mapping[str, float]) -> None:
        """Count from now, starting with these numbers by role, and 0 for other roles."""
        for role, count in self._counts.items():
            self._bring_up(count)
            count.done = done.get(role, 0.0)
        # A resumed run may not have set the drives of all roles again yet.
        for role in done.keys() - self._counts.keys():
            self._counts[role] = _Count(done[role])

    def done(self) -> dict[str, float]:
        """Return the number of cycles of each role so far, except roles that never moved."""
        for count in self._counts.values():
            self._bring_up(count)
        return {role: count.done for role, count in self._counts.items()}

    def _bring_up(self, count: _Count) -> None:
        now_s = self._clock.monotonic_s()
        if count.since_s is not None:
            count.done += (now_s - count.since_s) * count.frequency_hz
            count.since_s = now_s
