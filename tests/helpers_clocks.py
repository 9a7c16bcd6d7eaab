"""Instruments whose sample clocks go as they like, in simulated time."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.data import Block
from rigrunner.api.devices import ChannelInfo, Identity

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from rigrunner.clock import SimulatedClock

BLOCK_S = 0.1


@dataclass
class Sampler:
    """Samples signals of the true time by a clock of its own, and hands blocks over late."""

    clock: SimulatedClock
    signals: Mapping[str, Callable[[np.ndarray], np.ndarray]]
    """Channel to its value at true times (n,)."""
    sample_rate_hz: float = 10_000.0
    clock_error: float = 0.0
    """Relative: of a clock that is fast, above 0."""
    start_s: float = 0.0
    """How long after it is asked to it begins to sample."""
    latency_s: float = 0.0
    """The least that a block is late by."""
    jitter_s: float = 0.0
    """The mean of what more it is late by, exponentially distributed."""
    seed: int = 0
    lost: int | None = None
    """The block that never comes."""
    drives: Sequence[object] = ()
    non_blocking: bool = True
    is_open: bool = field(default=False, init=False)
    streams: int = field(default=0, init=False)

    @property
    def channels(self) -> Sequence[ChannelInfo]:
        return [ChannelInfo(name, "N·m", name) for name in self.signals]

    def connect(self, timeout_s: float) -> Identity:  # noqa: ARG002
        return Identity("Clocks", "sampler", str(self.seed))

    def make_safe(self) -> Mapping[str, float]:
        return {}

    def close(self) -> None:
        pass

    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        now = np.array([self.clock.monotonic_s()])
        return {name: float(self.signals[name](now)[0]) for name in channels}

    def stream(self, channels: Sequence[str], duration_s: float, stop) -> Iterator[Block]:
        self.streams += 1
        rng = np.random.default_rng([self.seed, self.streams])
        rate = self.sample_rate_hz * (1 + self.clock_error)
        began_s = self.clock.monotonic_s() + self.start_s
        size = round(BLOCK_S * self.sample_rate_hz)
        self.is_open = True
        try:
            for index, first in enumerate(range(0, round(duration_s * self.sample_rate_hz), size)):
                if stop.is_set() or index == self.lost:
                    return
                true_s = began_s + (first + np.arange(size)) / rate
                late_s = self.latency_s + rng.exponential(self.jitter_s or 1e-12)
                due_s = began_s + (first + size) / rate + late_s
                self.clock.sleep(max(due_s - self.clock.monotonic_s(), 0.0))
                values = {name: self.signals[name](true_s) for name in channels}
                began_at_s = due_s - size / self.sample_rate_hz
                yield Block(self.sample_rate_hz, first, began_at_s, values)
        finally:
            self.is_open = False
