"""What goes wrong with the blocks of a stream: lost, twice, in the wrong order, at wrong times."""

from __future__ import annotations

from dataclasses import replace
from itertools import chain
from math import ceil
from typing import TYPE_CHECKING

from rigrunner_plugins.devices.fault.answers import affect

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    import numpy as np

    from rigrunner.api import Block, Clock
    from rigrunner_plugins.devices.fault.settings import FaultSettings, Kind


def extra_s(fault: FaultSettings) -> float:
    """Return how much longer the device has to stream, for what falls into a gap."""
    return fault.extent_si if fault.kind in ("gap", "hidden gap") else 0.0


def spoilt_blocks(
    fault: FaultSettings,
    blocks: Iterator[Block],
    samples: int,
    rng: np.random.Generator,
    clock: Clock,
) -> Iterator[Block]:
    """Yield the blocks of a stream of so many samples with one fault in them."""
    first = next(blocks, None)
    if first is None:
        return
    total = max(1, ceil(samples / max(first.samples, 1)))
    chosen = int(rng.integers(1, total)) if total > 1 else 0
    all_blocks = chain([first], blocks)
    spoil = _SPOILS.get(fault.kind)
    if spoil is not None:
        yield from spoil(fault, all_blocks, chosen)
        return
    for index, block in enumerate(all_blocks):
        if index == chosen:
            affect(fault, "stream", clock)
        yield block


def _dropped(fault: FaultSettings, blocks: Iterator[Block], chosen: int) -> Iterator[Block]:  # noqa: ARG001  (no extent)
    for index, block in enumerate(blocks):
        if index != chosen:
            yield block


def _repeated(fault: FaultSettings, blocks: Iterator[Block], chosen: int) -> Iterator[Block]:  # noqa: ARG001  (no extent)
    for index, block in enumerate(blocks):
        yield block
        if index == chosen:
            yield block


def _wrong_order(fault: FaultSettings, blocks: Iterator[Block], chosen: int) -> Iterator[Block]:  # noqa: ARG001  (no extent)
    delayed: Block | None = None
    for index, block in enumerate(blocks):
        if index == max(chosen - 1, 0):
            delayed = block
            continue
        yield block
        if delayed is not None:
            yield delayed
            delayed = None
    if delayed is not None:
        yield delayed


def _time_back(fault: FaultSettings, blocks: Iterator[Block], chosen: int) -> Iterator[Block]:
    for index, block in enumerate(blocks):
        is_late = index >= chosen
        yield replace(block, monotonic_s=block.monotonic_s - is_late * fault.extent_si)


def _gap(fault: FaultSettings, blocks: Iterator[Block], chosen: int) -> Iterator[Block]:
    """Count on as if no sample were missing; the times show it, unless the gap is hidden."""
    begin = end = -1
    for index, block in enumerate(blocks):
        gap = max(1, round(fault.extent_si * block.rate_hz))
        if index == chosen:
            begin, end = block.first_sample, block.first_sample + gap
        if begin < 0:
            yield block
            continue
        remaining = _tail(block, end)
        if remaining is not None:
            shift_s = gap / block.rate_hz if fault.kind == "hidden gap" else 0.0
            at_s = remaining.monotonic_s - shift_s
            yield replace(remaining, first_sample=remaining.first_sample - gap, monotonic_s=at_s)


def _tail(block: Block, sample: int) -> Block | None:
    """Return what of a block comes from that sample on."""
    skip = max(sample - block.first_sample, 0)
    if skip >= block.samples:
        return None
    channels = {name: values[skip:] for name, values in block.channels.items()}
    at_s = block.monotonic_s + skip / block.rate_hz
    return replace(
        block, first_sample=block.first_sample + skip, monotonic_s=at_s, channels=channels
    )


_SPOILS: dict[Kind, Callable[[FaultSettings, Iterator[Block], int], Iterator[Block]]] = {
    "dropped blocks": _dropped,
    "repeated block": _repeated,
    "wrong order": _wrong_order,
    "gap": _gap,
    "hidden gap": _gap,
    "time back": _time_back,
}
