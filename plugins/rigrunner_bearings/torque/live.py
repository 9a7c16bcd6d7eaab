"""A recording that goes on, in windows of a few whole cycles: each cycle is in one of them."""

from __future__ import annotations

from dataclasses import replace
from math import ceil, floor
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner.api.analysis.requirements import LEAST_CYCLES
from rigrunner_bearings.torque.channels import motion_channel, set_point, torque_channel
from rigrunner_bearings.torque.motion import find_motion

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api import Array, Block, Recording, RunData

WINDOW_CYCLES = LEAST_CYCLES + 3
"""In a window, at least: a gross error among as few is still told, and enough remain."""
LEAST_S = 1.0
"""Of a window: the compensation costs the same for one cycle as for many."""
MOST_SAMPLES = 12_000_000
"""Of a window: what swings more slowly is analysed once it is recorded."""
MARGIN = 0.5
"""Of a cycle, before the first and after the last of a window: starts are looked for around it."""
LOOKED_AT = 2000
"""Samples of a cycle: enough to see about where it starts, with half a cycle to spare."""
_LONGER = 1.25


class Windows:
    """Cuts the blocks of one recording into recordings of whole cycles, one after the other.

    The last cycle of a window ends where the first one of the next begins. No more is kept than
    the samples of one window, of the torque and of what shows the motion.
    """

    def __init__(self, empty: Recording, run: RunData) -> None:
        """Begin with all of a recording but its samples, and the run that it belongs to.

        Raises DataError where it has no torque, or no frequency was set.
        """
        self._empty = empty
        self._run = run
        self._torque = torque_channel(empty, run.instruments)
        _, motion = motion_channel(empty)
        self._names = [name for name in (motion, self._torque) if name]
        set_hz = set_point(empty, self._torque, "frequency")
        if not set_hz > 0:
            raise DataError(f"recording {empty.name} has no cycles: its frequency was set to zero")
        self._period = empty.rate_hz / set_hz
        self._channels: dict[str, list[Array]] = {}
        self._samples = self._next = 0
        self._wanted = self._enough()
        self._begin_anew()

    def take(self, block: Block) -> Iterator[Recording]:
        """Take the next block; yield the windows that it completes. After a gap it begins anew.

        Raises DataError where a window is as long as it may be, and has too few cycles.
        """
        if block.first_sample != self._next:
            self._begin_anew()
        self._next = block.first_sample + block.samples
        self._samples += block.samples
        for name in self._names:
            self._channels[name].append(block.channels[name])
        while self._samples >= self._wanted:
            if window := self._cut():
                yield window
            elif self._samples > MOST_SAMPLES:
                self._begin_anew()
                raise DataError(f"too few cycles in {MOST_SAMPLES} samples to analyse them live")
            else:
                self._wanted = min(_LONGER * self._samples, MOST_SAMPLES + 1)

    def _begin_anew(self) -> None:
        self._channels = {name: [] for name in self._names}
        self._samples = 0
        self._wanted = self._enough()

    def _enough(self) -> float:
        """Return how many samples hold a window with both margins, wherever its cycles start."""
        cycles = max(WINDOW_CYCLES, ceil(LEAST_S * self._empty.rate_hz / self._period))
        return min((cycles + 1 + 2 * MARGIN) * self._period, MOST_SAMPLES + 1)

    def _cut(self) -> Recording | None:
        """Return the whole cycles that are there, with their margins; None if they are too few."""
        channels = {name: np.concatenate(parts) for name, parts in self._channels.items()}
        starts = self._starts(replace(self._empty, channels=channels))
        if len(starts) <= WINDOW_CYCLES:
            return None
        self._period = float(np.diff(starts).mean())
        margin = MARGIN * self._period
        first, last = max(floor(starts[0] - margin), 0), floor(starts[-1] - margin)
        end = ceil(starts[-1] + margin)
        self._channels = {name: [values[last:].copy()] for name, values in channels.items()}
        self._samples -= last
        self._wanted = self._enough()
        window = {name: values[first:end] for name, values in channels.items()}
        return replace(self._empty, channels=window)

    def _starts(self, recording: Recording) -> Array:
        """Return about where cycles start that have a margin behind them, in samples."""
        step = max(1, int(self._period / LOOKED_AT))
        looked_at = {name: values[::step] for name, values in recording.channels.items()}
        coarse = replace(recording, rate_hz=recording.rate_hz / step, channels=looked_at)
        try:
            starts = step * find_motion(coarse, self._run, looked_at[self._torque]).starts
        except DataError:
            return np.empty(0)
        margin = MARGIN * float(np.diff(starts).mean())
        return np.asarray(starts[starts + margin <= recording.samples])
