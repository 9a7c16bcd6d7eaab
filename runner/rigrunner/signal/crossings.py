"""Where a signal crosses from one side to the other, in spite of noise between the two.

Hysteresis: at `low` and below a sample is low, at `high` and above it is high, and between it says
nothing. A rise is a low sample and the next high one, with no low one between the two.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ulp
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from rigrunner.signal.blocks import blocks
from rigrunner.signal.extremes import extremes

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from rigrunner.api.data import Array, Mask, Samples

    IntArray = NDArray[np.intp]

STRIDES = (256, 64)
"""Of the first look, which finds about where the crossings are."""
LOOKS = 32
"""In a cycle, at least; with fewer a half may be missed."""
PIECE = 4096
"""In which the first and the last sample outside are looked for."""
LONG = 25_000
"""Samples of a cycle, of which to look at each but once is worth two calls of numpy."""
HALF = 2  # a share of a half leaves nothing between the ends: one cut
SHARES = (4, HALF)
"""Of the time from low to high: what noise may take of it at each end, first as is usual."""


def rises(values: Samples, low: float, high: float) -> tuple[IntArray, IntArray]:
    """Return the last sample <= low before each rise, and the first >= high after it.

    Indices into values of shape (n,), each of shape (rises,); low < high.
    """
    rises_found = [np.empty((2, 0), np.intp)]
    low_at: int | None = None
    for at, block in blocks(values):
        ends = _outer(block, low, high)
        if ends is None:
            continue
        first, last = ends
        if low_at is not None and block[first] >= high:
            rises_found.append(np.array([[low_at], [at + first]]))
        rises_found.append(np.add(at, _in_block(block, low, high)))
        low_at = at + last if block[last] <= low else None
    before, after = np.concatenate(rises_found, axis=1)
    return before, after


def _outer(values: Array, low: float, high: float) -> tuple[int, int] | None:
    """Return the first sample that is low or high, and the last one; None without any."""
    for first in range(0, len(values), PIECE):
        part = values[first : first + PIECE]
        outside = (part <= low) | (part >= high)
        if outside.any():
            break
    else:
        return None
    for end in range(len(values), 0, -PIECE):
        part = values[max(end - PIECE, 0) : end]
        outside_at_end = (part <= low) | (part >= high)
        if outside_at_end.any():
            break
    return first + int(np.argmax(outside)), end - 1 - int(np.argmax(outside_at_end[::-1]))


def _in_block(values: Array, low: float, high: float) -> tuple[IntArray, IntArray]:
    # Few samples lie near a crossing. A look at some shows where; that no other says otherwise is
    # then seen by extremes, which cost a tenth of comparing and listing them all.
    look = _look(values, low, high)
    if look is None:
        return _turns(values <= low, values >= high)
    first, last = look.first, look.last
    parts = [
        _turns(values[: first + 1] <= low, values[: first + 1] >= high),
        _between(look),
        np.add(last, _turns(values[last:] <= low, values[last:] >= high)),
    ]
    before, after = np.concatenate(parts, axis=1)
    return before, after


def beyond(middle: float, limit: float) -> tuple[float, float]:
    """Return the greatest number that is below `middle` by more than a limit, and the least above.

    Exactly those for which x - middle < -limit, and x - middle > limit, in floating point.
    """
    low = -_least(lambda x: -x - middle < -limit, limit - middle, limit)
    return low, _least(lambda x: x - middle > limit, middle + limit, limit)


def _least(holds: Callable[[float], bool], near: float, limit: float) -> float:
    """Return the least number for which something holds, by bisection about where it begins to."""
    # Both subtractions round, so the place is a few ulp from where it is without rounding.
    margin = 4 * ulp(abs(near) + limit)
    below, above = near - margin, near + margin
    while below < (middle := (below + above) / 2) < above:
        below, above = (below, middle) if holds(middle) else (middle, above)
    return above


def _between(look: _Look) -> tuple[IntArray, IntArray]:
    """Return the rises from the first sample that the look shows outside to the last one."""
    for share in SHARES:
        near = _Near.of(look, share)
        if near is not None and near.holds():
            return near.rises()
    part = look.values[look.first : look.last + 1]
    before, after = _turns(part <= look.low, part >= look.high)
    return before + look.first, after + look.first


def _turns(is_low: Mask, is_high: Mask) -> tuple[IntArray, IntArray]:
    """Return the same of flags, each of shape (n,)."""
    outside = np.flatnonzero(is_low | is_high)
    side = is_high[outside]
    rising = np.flatnonzero(side[1:] > side[:-1])
    return outside[rising], outside[rising + 1]


def _spans(begins: Sequence[IntArray], ends: Sequence[IntArray]) -> list[list[int]]:
    spans = np.stack([np.concatenate(begins), np.concatenate(ends)], axis=1)
    return cast("list[list[int]]", spans.tolist())


@dataclass(frozen=True, eq=False)
class _Look:
    """The crossings that every n-th sample shows: indices of both sides of each."""

    values: Array
    low: float
    high: float
    stride: int
    first: int
    """The first of its samples that is high or low, and the last one."""
    last: int
    up: tuple[IntArray, IntArray]
    down: tuple[IntArray, IntArray]


def _look(values: Array, low: float, high: float) -> _Look | None:
    """Return None where the looks are too few to a cycle."""
    for stride in STRIDES:
        samples = values[::stride].copy()
        is_low, is_high = samples <= low, samples >= high
        up, down = _turns(is_low, is_high), _turns(is_high, is_low)
        # No rise at all means nothing: all of them may lie between two looks.
        if 0 < LOOKS * len(up[0]) <= len(samples):
            ups, downs = ((stride * before, stride * after) for before, after in (up, down))
            outside = is_low | is_high
            first = stride * int(np.argmax(outside))
            last = stride * (len(samples) - 1 - int(np.argmax(outside[::-1])))
            return _Look(values, low, high, stride, first, last, ups, downs)
    return None


@dataclass(frozen=True, eq=False)
class _Near:
    """Where to look for crossings: each lies about its `begin` and its `end`.

    A rise's last low sample is one of `wide` before its begin, its first high one of `wide` from
    its end on; so are a fall's, the other way. Begin and end may be the same sample.
    """

    look: _Look
    wide: int
    up: tuple[IntArray, IntArray]
    down: tuple[IntArray, IntArray]
    one_cut: bool

    @classmethod
    def of(cls, look: _Look, share: int) -> _Near | None:
        """Return None where nothing can be won by it."""
        # With one cut the windows reach over the widest gap, from its middle. With two they must
        # not meet in the narrowest. They pay only while they are less than half of all samples.
        gaps = np.concatenate([after - before for before, after in (look.up, look.down)])
        one_cut = share == HALF
        if one_cut:
            wide = int(gaps.max()) // 2 + 1
            up, down = (((before + after) // 2,) * 2 for before, after in (look.up, look.down))
        else:
            wide = int(gaps.min()) // share
            up, down = ((before + wide, after - wide) for before, after in (look.up, look.down))
        pays = (one_cut or wide > 2 * look.stride) and wide * len(gaps) < len(look.values) // 2
        return cls(look, wide, up, down, one_cut) if pays else None

    def holds(self) -> bool:
        """Return whether all samples between the crossings are on the side that the look says."""
        look = self.look
        if len(look.values) >= LONG * len(self.up[0]):
            # the same by fewer looks: the one extreme of each half that could say otherwise
            no_high, no_low = self._halves()
            return all(
                np.maximum.reduce(look.values[begin:end]) < look.high for begin, end in no_high
            ) and all(np.minimum.reduce(look.values[begin:end]) > look.low for begin, end in no_low)
        begin, end = self.up
        ends = [begin, self.down[0]] if self.one_cut else [begin, end, *self.down]
        cuts = np.sort(np.concatenate(ends))
        edges = np.concatenate([[look.first], cuts, [look.last + 1]])
        least, greatest = extremes(look.values, edges)
        # Stretches follow each other: low, between, high, between; or low, high, with one cut.
        turn = len(ends)
        low_first = 0 if begin[0] == cuts[0] else turn // 2
        stretch = (np.arange(len(least)) + low_first) % turn
        may_be_high, may_be_low = stretch == turn // 2, stretch == 0
        return bool(
            ((greatest < look.high) | may_be_high).all() and ((least > look.low) | may_be_low).all()
        )

    def _halves(self) -> tuple[list[list[int]], list[list[int]]]:
        """Return from where to where no sample may be high, and where none may be low.

        From a fall's begin to the end of the next rise, and the other way: while it changes, both.
        """
        start, stop = np.array([self.look.first]), np.array([self.look.last + 1])
        (rise, risen), (fall, fallen) = self.up, self.down
        rises_first = not len(fall) or rise[0] < fall[0]
        falls_last = bool(len(fall)) and fall[-1] > rise[-1]
        low = [start, fall] if rises_first else [fall]
        high = [rise] if rises_first else [start, rise]
        low_end = [risen, stop] if falls_last else [risen]
        high_end = [fallen] if falls_last else [fallen, stop]
        return _spans(low, low_end), _spans(high, high_end)

    def rises(self) -> tuple[IntArray, IntArray]:
        """Return the last low sample before each rise, and the first high one after it."""
        (begin, end), width = self.up, self.wide + 1
        windows = sliding_window_view(self.look.values, width)
        last = np.maximum(begin - width, 0)
        first = np.minimum(end, len(self.look.values) - width)
        low, high = windows[last] <= self.look.low, windows[first] >= self.look.high
        back = np.argmax(low[:, ::-1], axis=1)
        return last + self.wide - back, first + np.argmax(high, axis=1)
