"""Checks of streams: gapless, finite, complete, and stopped on request."""

from __future__ import annotations

from contextlib import nullcontext
from numbers import Real
from typing import TYPE_CHECKING, Protocol

import numpy as np

from rigrunner.api.cleanup import closed_after
from rigrunner.api.data import Block
from rigrunner.api.errors import DeviceLostError, DeviceRejectedError
from rigrunner.api.member import Member
from rigrunner.api.samples import as_samples

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

    from rigrunner.api.data import Array
    from rigrunner.api.devices import StopToken
    from rigrunner.engine.drive_watch import DriveWatch
    from rigrunner.engine.interlocks import Guard
    from rigrunner.rig import Rig

_POSSIBLE_ROUNDING = 1
"""A duration that is not a whole number of samples may be rounded down."""

LEAST_GAP_S = 0.15
"""Allowed disagreement of block times and sample counts: many devices stamp a block when it
arrives, and one may wait for another."""

MOST_EMPTY = 10_000
"""Allowed number of consecutive empty blocks."""

CLOCKS_DISAGREE = 1e-3
"""Allowed disagreement of two clocks, relative to the time since the first block."""


class StreamSession(Protocol):
    """What a stream needs of a session of the engine."""

    @property
    def rig(self) -> Rig:
        """The devices."""
        ...

    @property
    def stop(self) -> StopToken:
        """Ends the stream when set."""
        ...

    @property
    def guard(self) -> Guard:
        """Checks the samples of monitored channels."""
        ...

    @property
    def drives(self) -> DriveWatch | None:
        """Monitors the drives that were set."""
        ...

    def check(self) -> None:
        """Raise what prevents the step from continuing."""
        ...


def checked_stream(
    session: StreamSession, role: str, channels: Sequence[str], duration_s: float
) -> Generator[Block]:
    """Yield the blocks of a device with channels named 'role.channel'.

    Raises AbortedError once the run has to stop, and a DeviceError once the step exceeds its time
    limit. Raises a DeviceError that names the role for blocks that are missing, repeated or out of
    order, for times that decrease or leave a gap, for samples that are missing, not numbers or not
    finite, for fewer samples than the duration needs, and for a stream that does not end.
    """
    rig = session.rig
    rate_hz, received, empty = rig.sample_rate_hz(role), 0, 0
    promised = rate_hz * duration_s
    times = _Times(role, rate_hz)
    stream = rig.stream(role, channels, duration_s, session.stop)
    unwatched = nullcontext() if session.drives is None else session.drives.streaming(role)
    with unwatched, closed_after(stream, "ending the stream") as blocks:
        for raw_block in blocks:
            block = _checked(role, raw_block, channels, rate_hz, received)
            times.take(block)
            empty = 0 if block.samples else empty + 1
            # `received` is without this block: the last one may reach beyond the end.
            if empty > MOST_EMPTY or (block.samples and received > promised + _POSSIBLE_ROUNDING):
                raise DeviceRejectedError(
                    f"{role}: the stream does not end: {received} samples and another block, asked"
                    f" for {promised:.0f} ({duration_s:g} s at {rate_hz:g} Hz)"
                )
            received += block.samples
            session.guard.feed(role, block)
            named: dict[str, Array] = {
                Member(role, name): values for name, values in block.channels.items()
            }
            yield Block(block.rate_hz, block.first_sample, block.monotonic_s, named)
            session.check()
    # First: a stream that a stop request ended is too short, but no device was lost.
    session.check()
    times.check_gaps()
    if received < promised - _POSSIBLE_ROUNDING:
        raise DeviceLostError(
            f"{role}: the stream ended after {received} samples,"
            f" {promised:.0f} were expected ({duration_s:g} s at {rate_hz:g} Hz)"
        )


def _checked(
    role: str, block: object, channels: Sequence[str], rate_hz: float, received: int
) -> Block:
    """Return the block with the requested channels as arrays of float64."""
    if not isinstance(block, Block) or not isinstance(block.monotonic_s, Real):
        what = f"{type(block).__name__} at sample {received}"
        raise DeviceRejectedError(
            f"{role}: the stream gave a {what}, which is not a Block with times"
        )
    if block.rate_hz != rate_hz:
        raise DeviceRejectedError(
            f"{role}: the stream has {block.rate_hz:g} samples per second, not {rate_hz:g}"
        )
    if block.first_sample != received:
        what = "has a gap" if block.first_sample > received else "came twice, or in a wrong order"
        raise DeviceLostError(
            f"{role}: the stream {what}: sample {block.first_sample} came, {received} was due"
        )
    # A driver may stream more channels than were requested; they are left out here.
    values = {name: _samples(role, name, block, received) for name in channels}
    return Block(rate_hz, received, block.monotonic_s, values)


def _samples(role: str, name: str, block: Block, received: int) -> Array:
    values = block.channels.get(name)
    if values is None or np.shape(values) != (block.samples,):
        raise DeviceLostError(
            f"{role}.{name}: the block at sample {received} lacks samples of this channel"
        )
    try:
        values = as_samples(values)
    except TypeError as error:
        what = f"the samples from {received} on are {error}, expected numbers, float64"
        raise DeviceRejectedError(f"{role}.{name}: {what}") from error
    finite = np.isfinite(values)
    if not finite.all():
        where = received + int(np.argmin(finite))
        raise DeviceLostError(f"{role}.{name}: sample {where} is {values[where - received]}")
    return values


class _Times:
    """Checks that the times of blocks agree with their samples."""

    def __init__(self, role: str, rate_hz: float) -> None:
        self._role = role
        self._rate_hz = rate_hz
        self._times_s: list[float] = []
        self._firsts: list[int] = []

    def take(self, block: Block) -> None:
        """Add a block; raise DeviceLostError for a decreasing time."""
        last_s = self._times_s[-1] if self._times_s else block.monotonic_s
        # Not written as "<": NaN fails this comparison, and so is refused.
        if not block.monotonic_s >= last_s:
            raise DeviceLostError(
                f"{self._role}: time goes back by {last_s - block.monotonic_s:.3g} s"
                f" at sample {block.first_sample}"
            )
        self._times_s.append(block.monotonic_s)
        self._firsts.append(block.first_sample)

    def check_gaps(self) -> None:
        """Raise DeviceLostError if there was a time without samples.

        A block that only arrived late is followed by one on time; after a gap all are late.
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
