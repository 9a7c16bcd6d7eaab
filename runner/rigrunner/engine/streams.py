"""Streams as the engine accepts them: gapless, finite, complete, and stopped when asked."""

from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.data import Block
from rigrunner.api.errors import DeviceLostError, DeviceRejectedError

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

    from rigrunner.engine.session import Session

_POSSIBLE_ROUNDING = 1
"""A duration that is no whole number of samples may be rounded down."""

LEAST_GAP_S = 0.15
"""By how much the times of blocks may disagree with their count of samples: many devices stamp a
block when it arrives, and one may wait for another."""

CLOCKS_DISAGREE = 1e-3
"""Of the time since the first block: two clocks need not run alike."""


def checked_stream(
    session: Session, role: str, channels: Sequence[str], duration_s: float
) -> Generator[Block]:
    """Yield the blocks of a device with channels named 'role.channel'.

    Raises AbortedError once the run is asked to stop, and a DeviceError once the step's time is
    over; one that names the role for blocks that are missing, come twice or in the wrong order, for
    times that go back or leave a gap, for samples that are missing or not finite, and for fewer of
    them than the duration needs.
    """
    rig = session.rig
    rate_hz, received = rig.sample_rate_hz(role), 0
    times = _Times(role, rate_hz)
    with closing(rig.stream(role, channels, duration_s, session.stop)) as blocks:
        for block in blocks:
            _check(role, block, channels, rate_hz, received)
            times.take(block)
            received += block.samples
            session.guard.feed(role, block)
            yield _with_role(role, block, channels)
            session.check()
    session.check()
    times.check_gaps()
    if received < rate_hz * duration_s - _POSSIBLE_ROUNDING:
        raise DeviceLostError(
            f"{role}: the stream ended after {received} samples,"
            f" {rate_hz * duration_s:.0f} were promised ({duration_s:g} s at {rate_hz:g} Hz)"
        )


def _check(role: str, block: Block, channels: Sequence[str], rate_hz: float, received: int) -> None:
    if block.rate_hz != rate_hz:
        raise DeviceRejectedError(
            f"{role}: the stream has {block.rate_hz:g} samples per second, not {rate_hz:g}"
        )
    if block.first_sample != received:
        what = "has a gap" if block.first_sample > received else "came twice, or in a wrong order"
        raise DeviceLostError(
            f"{role}: the stream {what}: sample {block.first_sample} came, {received} was due"
        )
    for name in channels:
        _check_channel(role, name, block, received)


def _check_channel(role: str, name: str, block: Block, received: int) -> None:
    values = block.channels.get(name)
    if values is None or np.shape(values) != (block.samples,):
        raise DeviceLostError(
            f"{role}.{name}: the block at sample {received} lacks samples of this channel"
        )
    finite = np.isfinite(values)
    if not finite.all():
        where = received + int(np.argmin(finite))
        raise DeviceLostError(f"{role}.{name}: sample {where} is {values[where - received]}")


class _Times:
    """Whether the blocks' times go on as their samples do."""

    def __init__(self, role: str, rate_hz: float) -> None:
        self._role = role
        self._rate_hz = rate_hz
        self._times_s: list[float] = []
        self._firsts: list[int] = []

    def take(self, block: Block) -> None:
        """Take note of a block; raise DeviceLostError for a time that goes back."""
        last_s = self._times_s[-1] if self._times_s else block.monotonic_s
        if not block.monotonic_s >= last_s:
            raise DeviceLostError(
                f"{self._role}: time goes back by {last_s - block.monotonic_s:.3g} s"
                f" at sample {block.first_sample}"
            )
        self._times_s.append(block.monotonic_s)
        self._firsts.append(block.first_sample)

    def check_gaps(self) -> None:
        """Raise DeviceLostError where time passed of which no block holds the samples.

        A block that was only late to arrive is followed by one that is not; after a gap all are.
        """
        counted_s = np.array(self._firsts) / self._rate_hz
        late_s = np.array(self._times_s) - counted_s
        before_s = np.minimum.accumulate(late_s)[:-1]
        after_s = np.minimum.accumulate(late_s[::-1])[::-1][1:]
        gaps_s = after_s - before_s - CLOCKS_DISAGREE * counted_s[1:]
        if len(gaps_s) and gaps_s.max() > LEAST_GAP_S:
            where = int(gaps_s.argmax())
            raise DeviceLostError(
                f"{self._role}: a gap in time of {after_s[where] - before_s[where]:.3g} s before"
                f" sample {self._firsts[where + 1]}, though none is missing by their count"
            )


def _with_role(role: str, block: Block, channels: Sequence[str]) -> Block:
    named = {f"{role}.{name}": block.channels[name] for name in channels}
    return Block(block.rate_hz, block.first_sample, block.monotonic_s, named)
