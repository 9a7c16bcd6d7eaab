"""Hands out prepared samples in blocks, at the pace of the injected clock."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import Block

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api import Array, Clock, StopToken

BLOCK_S = 0.1
"""A stop is looked at between blocks."""


def paced_blocks(
    values: Mapping[str, Array], rate_hz: float, clock: Clock, stop: StopToken
) -> Iterator[Block]:
    """Yield channels of shape (n,) in blocks of at most 0.1 s, each when its time has passed.

    The token is looked at before every block.
    """
    started_s = clock.monotonic_s()
    size = max(1, int(BLOCK_S * rate_hz))
    for first in range(0, max(map(len, values.values()), default=0), size):
        if stop.is_set():
            return
        part = {name: array[first : first + size] for name, array in values.items()}
        block = Block(rate_hz, first, started_s + first / rate_hz, part)
        due_s = started_s + (first + block.samples) / rate_hz
        clock.sleep(max(0.0, due_s - clock.monotonic_s()))
        yield block
