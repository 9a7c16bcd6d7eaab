"""Removal of single-sample spikes before anything else looks at the samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy
from numpy.lib.stride_tricks import sliding_window_view

from rigrunner.signal.blocks import BLOCK, steps
from rigrunner.signal.order import Bracket, median, middle

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from rigrunner.api.data import Array, Samples

    IntArray = NDArray[np.intp]

MAD_TO_SIGMA = 1.482602218505602
"""1 / Phi^-1(3/4): the median absolute deviation of a normal distribution, as its sigma."""

DEFAULT_THRESHOLD = 6.0
"""In robust sigmas: of normal samples two in 10⁹ lie further out."""

LESS = 0.8
"""Of the first stretch's median: that of all is as a rule not below."""
FEW = 0.02
"""Of a stretch: more suspects than that are not looked at before the median is known."""


def hampel(values: Array, window: int, threshold: float = DEFAULT_THRESHOLD) -> tuple[Array, int]:
    """Return values of shape (n,) with spikes replaced by the local median, and their number.

    A sample is a spike if it is further than `threshold` robust sigmas from the median of the
    `window` samples around it (Hampel identifier: Pearson, IEEE Trans. Control Syst. Technol.
    10(1), 2002). Sigma is the median absolute deviation in that window, which is large on steep
    slopes; but never less than what is usual in the whole record, so that a quiet stretch does not
    make spikes of good samples. An even window is widened by one. Raises ValueError for a window
    below 3.
    """
    cleaned, count = despiked(values, window, threshold)
    return np.array(cleaned), count


def despiked(
    values: Samples, window: int, threshold: float = DEFAULT_THRESHOLD
) -> tuple[Samples, int]:
    """Return the same of samples that need not fit into memory: as a rule they are read once."""
    if window < 3:  # noqa: PLR2004  (two neighbours are the least that can outvote a spike)
        raise ValueError(f"a window of {window} samples cannot tell a spike; 3 is the least")
    half = window // 2
    spikes = _spikes_at_once(values, half, threshold) if len(values) > BLOCK else None
    if spikes is None:
        spikes = _spikes_of(values, half, threshold)
    return Replaced(values, spikes.index, spikes.new), len(spikes.index)


def _spikes_of(values: Samples, half: int, threshold: float) -> _Spikes:
    stretches = list(_stretches(values, half)) if len(values) <= BLOCK else None

    def walk() -> Iterator[_Stretch]:
        # Short records stay in memory for the second walk; of longer ones each walk reads again.
        return iter(stretches or _stretches(values, half))

    usual = MAD_TO_SIGMA * median(lambda: (part.deviation for part in walk()), len(values))
    return _Spikes.join([stretch.spikes(usual, threshold) for stretch in walk()])


def _spikes_at_once(values: Samples, half: int, threshold: float) -> _Spikes | None:
    """Return the same after a single walk; None where samples are not like their first stretch.

    The median over all is known only at the end. What is a spike by less than the median of the
    first stretch is kept until then, and what is none by that of all is left out.
    """
    bracket: Bracket | None = None
    parts: list[_Spikes] = []
    for stretch in _stretches(values, half):
        if bracket is None:
            bracket = Bracket.about(0.5, stretch.deviation, len(values))
            least = MAD_TO_SIGMA * LESS * bracket.low
        if np.count_nonzero(stretch.deviation > threshold * least) > FEW * len(stretch.deviation):
            return None
        bracket.take(stretch.deviation)
        parts.append(stretch.spikes(least, threshold))
    ranked = bracket.ranked(middle(len(values))) if bracket is not None else None
    if ranked is None or (usual := MAD_TO_SIGMA * float(np.mean(ranked))) < least:
        return None
    return _Spikes.join(parts).beyond(threshold * usual)


@dataclass(frozen=True, eq=False)
class Replaced:
    """Samples, some of which are others: those at the rising `index`."""

    values: Samples
    index: IntArray
    new: Array

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.values)

    def __getitem__(self, which: slice, /) -> Array:
        """Return a copy of those from one index to another."""
        begin, end, _ = which.indices(len(self))
        changed = self.values[begin:end].copy()
        inside = slice(*np.searchsorted(self.index, [begin, end]))
        changed[self.index[inside] - begin] = self.new[inside]
        return changed

    def __array__(self, dtype: object = None, *, copy: bool | None = None) -> Array:
        """Return all."""
        return self[:]


@dataclass(frozen=True, eq=False)
class _Spikes:
    """Which samples are spikes, how far each is from what stands for it, and that."""

    index: IntArray
    deviation: Array
    new: Array

    @classmethod
    def join(cls, parts: Sequence[_Spikes]) -> _Spikes:
        columns = zip(*((part.index, part.deviation, part.new) for part in parts), strict=True)
        return cls(*map(np.concatenate, columns))

    def beyond(self, limit: float) -> _Spikes:
        selected = self.deviation > limit
        return _Spikes(self.index[selected], self.deviation[selected], self.new[selected])


@dataclass(frozen=True, eq=False)
class _Stretch:
    """Some samples from `first` on, with what lies around them."""

    first: int
    deviation: Array
    """From the median of the window around each."""
    centre: Array
    """That median."""
    around: Array
    """The samples, with half a window before and behind."""

    def spikes(self, usual: float, threshold: float) -> _Spikes:
        # Few samples pass this, and only these need their window's own deviation, which is costly.
        suspects = np.flatnonzero(self.deviation > threshold * usual)
        width = len(self.around) - len(self.centre) + 1
        windows = sliding_window_view(self.around, width)[suspects]
        centre = np.median(windows, axis=1, keepdims=True)
        local = MAD_TO_SIGMA * np.median(np.abs(windows - centre), axis=1)
        spikes = suspects[self.deviation[suspects] > threshold * local]
        return _Spikes(self.first + spikes, self.deviation[spikes], self.centre[spikes])


def _stretches(values: Samples, half: int) -> Iterator[_Stretch]:
    """Yield all samples block by block; the first and the last one stand for what is beyond."""
    for first, end in steps(values):
        begin, behind = max(first - half, 0), min(end + half, len(values))
        missing = (half - (first - begin), half - (behind - end))
        around = np.pad(values[begin:behind], missing, mode="edge")
        medians = scipy.ndimage.median_filter(around, 2 * half + 1, mode="nearest")
        centre = medians[half : half + end - first]
        deviation = np.abs(around[half : half + end - first] - centre)
        yield _Stretch(first, deviation, centre, around)
