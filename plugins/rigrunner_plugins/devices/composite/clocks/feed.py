"""One part's stream as it comes in, and when each block of it came."""

from __future__ import annotations

import time
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DeviceError, DeviceLostError, DeviceRejectedError
from rigrunner.api.samples import as_samples

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from concurrent.futures import Future

    from rigrunner.api import Array, Block, Clock, StopToken
    from rigrunner_plugins.devices.composite.part import Part

_FIRST = 65_536
"""Samples for which there is room at first."""
Arrival = tuple["Block | None", float]


class Feed:
    """The samples of some channels of one part since its stream began.

    One block is asked for at a time, from the part's own thread, which looks at the clock at once.
    """

    def __init__(
        self, part: Part, channels: Sequence[str], duration_s: float, stop: StopToken, clock: Clock
    ) -> None:
        self.part = part
        self.rate_hz = float(part.device.sample_rate_hz)
        self.samples = 0
        self.is_over = False
        self._clock = clock
        self._buffers: dict[str, Array] = {name: np.empty(_FIRST) for name in channels}
        self._ends_s: list[float] = []
        self._arrived_s: list[float] = []
        device = part.device
        self._blocks: Iterator[Block] = part.call(
            "start the stream", lambda: iter(device.stream(list(channels), duration_s, stop))
        )
        self.pending: Future[Arrival] | None = None
        self._asked_s = 0.0

    @property
    def received_s(self) -> float:
        """How many seconds of samples have come."""
        return self.samples / self.rate_hz

    @property
    def arrivals(self) -> tuple[Array, Array]:
        """Seconds of samples at the end of each block (n,), and when it came (n,)."""
        return np.array(self._ends_s), np.array(self._arrived_s)

    def arrived_s(self, sample: int) -> float:
        """Return when the block came in which a sample is."""
        # Half a sample further: rounding must not find the block before.
        index = int(np.searchsorted(self._ends_s, (sample + 0.5) / self.rate_hz))
        return self._arrived_s[min(index, len(self._arrived_s) - 1)]

    def channel(self, name: str, begin: int, end: int) -> Array:
        """Return samples `begin` to `end` of a channel."""
        return self._buffers[name][begin : min(end, self.samples)]

    def ask(self) -> None:
        """Ask for the next block, unless that is under way."""
        if self.pending is None and not self.is_over:
            self.pending = self.part.ask("stream", self._next)
            self._asked_s = time.monotonic()

    @property
    def waiting_s(self) -> float:
        """How long the requested block has been waited for, by the wall clock."""
        is_waiting = self.pending is not None and not self.pending.done()
        return time.monotonic() - self._asked_s if is_waiting else 0.0

    def take(self) -> None:
        """Keep the block that has come; raise a DeviceError for one that cannot be used."""
        if self.pending is None or not self.pending.done():
            return
        future, self.pending = self.pending, None
        block, now_s = self.part.answer(future)
        if block is None:
            self.is_over = True
            return
        self._check(block)
        end = self.samples + block.samples
        for name in self._buffers:
            # The room doubles where it ends, so that long recordings are not copied again.
            while end > len(self._buffers[name]):
                buffer = self._buffers[name]
                self._buffers[name] = np.concatenate([buffer, np.empty_like(buffer)])
            self._buffers[name][self.samples : end] = block.channels[name]
        self.samples = end
        self._ends_s.append(self.received_s)
        self._arrived_s.append(now_s)

    def end(self) -> None:
        """End the stream on the device."""
        close = getattr(self._blocks, "close", None)
        if close is not None:
            with suppress(DeviceError):  # a device that hangs was reported already
                self.part.call("end the stream", close)

    def _next(self) -> Arrival:
        block = next(self._blocks, None)
        if block is None or not self.part.is_inline:
            return block, self._clock.monotonic_s()
        # Without threads others' waiting would count as its own: only it knows when it was.
        return block, block.monotonic_s + block.samples / block.rate_hz

    def _check(self, block: Block) -> None:
        name = self.part.name
        if block.rate_hz != self.rate_hz:
            message = f"{name}: the stream has {block.rate_hz:g} samples per second"
            raise DeviceRejectedError(f"{message}, not {self.rate_hz:g}")
        if block.first_sample != self.samples:
            message = f"{name}: sample {block.first_sample} came, {self.samples} was due"
            raise DeviceLostError(message)
        for channel in self._buffers:
            try:
                values = as_samples(block.channels.get(channel, ()))
            except TypeError as error:
                message = f"{channel}: the samples are {error}, expected real numbers"
                raise DeviceRejectedError(message) from error
            if len(values) != block.samples:
                raise DeviceLostError(f"{name}: the block at sample {self.samples} lacks samples")
