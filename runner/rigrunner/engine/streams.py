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


def checked_stream(
    session: Session, role: str, channels: Sequence[str], duration_s: float
) -> Generator[Block]:
    """Yield the blocks of a device with channels named 'role.channel'.

    Raises AbortedError once the run is asked to stop, and a DeviceError once the step's time is
    over; one that names the role for a gap, for samples that are missing or not finite, and for
    fewer of them than the duration needs.
    """
    rig = session.rig
    rate_hz, received = rig.sample_rate_hz(role), 0
    with closing(rig.stream(role, channels, duration_s, session.stop)) as blocks:
        for block in blocks:
            _check(role, block, channels, rate_hz, received)
            received += block.samples
            session.guard.feed(role, block)
            yield _with_role(role, block, channels)
            session.check()
    session.check()
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
        raise DeviceLostError(
            f"{role}: the stream has a gap: sample {block.first_sample} came, {received} was due"
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


def _with_role(role: str, block: Block, channels: Sequence[str]) -> Block:
    named = {f"{role}.{name}": block.channels[name] for name in channels}
    return Block(block.rate_hz, block.first_sample, block.monotonic_s, named)
