"""Cuts a recording of a swinging rig into cycles of the crank and puts them on its phase.

Phase and frequency come from the angle channel alone. The crank phase is 0 in the middle of the
forward stroke, where the swing angle passes 0 rising.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np
import scipy

from rigrunner.api import DataError
from rigrunner.signal.blocks import BLOCK, cycle_groups
from rigrunner.signal.crossings import beyond, rises
from rigrunner.signal.order import percentiles
from rigrunner_bearings.signal.half_turns import HalfTurns, HalfTurnSums
from rigrunner_bearings.signal.kinematics import max_angle

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from rigrunner.api import Array
    from rigrunner.api.data import Samples

HYSTERESIS = 0.3
"""Share of the amplitude that the angle must exceed on both sides of zero to be a swing."""

LEAST_SWING = 0.5
"""Share of the amplitude by the kinematics: less is noise of a rig at rest."""

SHORTEST = 0.5
"""Of the median: the least length of a cycle. No crank turns a single time twice as fast."""

REFINEMENTS = 4
BASELINES = 3
SPLINE_ORDER: Final = 5
SETTLED = 128
"""Samples beyond which the ends of a spline matter by less than 1e-40 (its pole is 0.43)."""


@dataclass(frozen=True, eq=False)
class Cycles:
    """The whole cycles of a recording.

    `starts` are fractional sample indices, shape (n + 1,): where each cycle starts, and where the
    last one ends. `frequency_hz` is that of each cycle, shape (n,). `offset_rad` and `ratio` are
    the angle channel's zero and the eccentric ratio that the measured swing shows.
    """

    starts: Array
    frequency_hz: Array
    offset_rad: float
    ratio: float

    @property
    def count(self) -> int:
        """How many whole cycles there are."""
        return len(self.frequency_hz)


def find_cycles(angle_rad: Samples, rate_hz: float, ratio: float) -> Cycles:
    """Find the whole cycles in an angle of shape (n,), sampled at rate_hz.

    Hysteresis finds the swings in any noise; then each start is refined by least squares of
    the guide bar's kinematics of eccentric ratio `ratio` over the half turn around it, with the
    offset and scale that the angle channel shows over all of them. Raises DataError if the angle
    does not swing through one whole cycle, or if one cycle is shorter than half the median.
    """
    # About where the angle rises through the middle of its range.
    low, high = percentiles(angle_rad, [2, 98])
    limit = HYSTERESIS * max((high - low) / 2, LEAST_SWING * max_angle(ratio))
    before, after = rises(angle_rad, *beyond((low + high) / 2, limit))
    starts = np.asarray((before + after) / 2)
    if len(starts) < 2:  # noqa: PLR2004  (a cycle has two ends)
        raise DataError(
            f"no whole cycle of about {np.rad2deg(max_angle(ratio)):.1f} deg in the angle",
            hint="record at least one whole swing, with the angle channel connected",
        )
    starts = _with_ends(starts, len(angle_rad))
    offset, scale = 0.0, 1.0
    for _ in range(REFINEMENTS):
        _refuse_short(starts, rate_hz)
        starts, offset, scale = _refine(angle_rad, starts, ratio)
    _refuse_short(starts, rate_hz)
    starts = starts[(starts >= 0) & (starts <= len(angle_rad) - 1)]
    return Cycles(starts, rate_hz / np.diff(starts), offset, scale * ratio)


def integrated_swing(velocity_rad_s: Array, rate_hz: float, ratio: float) -> Array:
    """Return the swing angle in rad from its velocity, both of shape (n,), sampled at rate_hz.

    An offset of the velocity makes the integral run away, and noise makes it wander: what the mean
    over each cycle does is taken off, as a cycle's mean angle is zero. Raises DataError like
    `find_cycles`, and for a velocity that does not change its sign.
    """
    if velocity_rad_s.min() >= 0 or velocity_rad_s.max() <= 0:
        raise DataError(
            "the velocity never changes its sign, so it is not that of a swing",
            hint="record the swing's velocity, not the crank's",
        )

    angle = scipy.signal.detrend(
        scipy.integrate.cumulative_trapezoid(velocity_rad_s, dx=1 / rate_hz, initial=0)
    )
    for _ in range(BASELINES):
        starts = find_cycles(angle, rate_hz, ratio).starts
        means = resample(angle, starts).mean(axis=1)
        middle = (starts[1:] + starts[:-1]) / 2
        angle = angle - np.interp(np.arange(len(angle)), middle, means)
    return np.asarray(angle)


def _refuse_short(starts: Array, rate_hz: float) -> None:
    """Raise DataError for starts that no crank can have: spikes, or a jump, made them."""
    lengths = np.diff(starts)
    if not lengths.min() > SHORTEST * np.median(lengths):
        where_s = starts[int(lengths.argmin())] / rate_hz
        raise DataError(
            f"a cycle at {where_s:.3g} s is shorter than half of the others",
            hint="the angle has spikes or jumps, or is another channel: check its wiring",
        )


def _with_ends(starts: Array, samples: int) -> Array:
    """Return the starts with those that lie too close to the record's ends for hysteresis."""
    period = float(np.median(np.diff(starts)))
    before, after = starts[0] - period, starts[-1] + period
    first = [before] if before >= 0 else []
    last = [after] if after <= samples - 1 else []
    return np.concatenate([first, starts, last])


def _refine(angle: Samples, starts: Array, ratio: float) -> tuple[Array, float, float]:
    """Return better starts, and the angle's offset and scale against the kinematics.

    The guide bar's angle has no mean over a cycle, so the offset is what the cycles' means are: the
    median, so that a disturbance in one of them does not matter.
    """
    period = np.gradient(starts)
    half = int(np.ceil(period.max() / 4))
    turns: HalfTurns | HalfTurnSums
    if starts[-1] - starts[0] <= BLOCK:
        turns = HalfTurns.around(angle, starts, period, half, ratio)
        edges = _edges(angle, starts)
        means = _means(angle[edges[0] : edges[-1]], edges - edges[0])
    else:
        turns, means = _in_groups(angle, starts, period, half, ratio)
    offset = float(np.median(means))
    scale = turns.scale(offset)
    return starts + turns.late(offset, scale), offset, scale


def _in_groups(
    angle: Samples, starts: Array, period: Array, half: int, ratio: float
) -> tuple[HalfTurnSums, list[float]]:
    """Return the half turns and the cycles' means of an angle that is read once, in groups."""
    sums: list[HalfTurnSums] = []
    means: list[float] = []
    edges = _edges(angle, starts)
    for cycles in cycle_groups(starts):
        first = max(edges[cycles.start] - half - 1, 0) // 2 * 2  # even, so that halves round alike
        part = angle[first : edges[cycles.stop] + half + 2]
        means += _means(part, edges[cycles.start : cycles.stop + 1] - first)
        rows = slice(cycles.start, cycles.stop + (cycles.stop == len(starts) - 1))
        sums.append(HalfTurnSums.around(part, starts[rows] - first, period[rows], half, ratio))
    return HalfTurnSums.joined(sums), means


def _edges(angle: Samples, starts: Array) -> NDArray[np.intp]:
    return np.rint(np.clip(starts, 0, len(angle))).astype(np.intp)


def _means(angle: Array, edges: NDArray[np.intp]) -> list[float]:
    return [angle[begin:end].mean() for begin, end in pairwise(edges)]


def resample(values: Samples, starts: Array, n: int = 1024) -> Array:
    """Return values of shape (samples,) as cycles of shape (len(starts) - 1, n).

    Row k is sampled at n equal steps of the crank phase from starts[k] (n even), by a quintic
    spline: flat to 1e-5 up to an eighth of the sampling rate. Where a cycle has more than n
    samples, it is sampled more densely and its harmonics from n/2 on are dropped, so that all
    samples count against the noise and none of it is folded down.
    """
    return np.concatenate([rows for _, rows in resampled(values, starts, n)])


def resampled(values: Samples, starts: Array, n: int) -> Iterator[tuple[slice, Array]]:
    """Yield the same in groups of cycles that fit into memory, with the slice of each group."""
    period = np.diff(starts)
    dense = n * max(1, int(np.ceil(period.max() / n)))
    if len(values) <= BLOCK:
        yield slice(0, len(period)), _rows(values[:], starts, dense, n)
        return
    for cycles in cycle_groups(starts):
        bounds = starts[cycles.start : cycles.stop + 1]
        first = max(int(bounds[0]) - SETTLED, 0)
        part = values[first : int(bounds[-1]) + SETTLED]
        yield cycles, _rows(part, bounds - first, dense, n)


def _rows(values: Array, starts: Array, dense: int, n: int) -> Array:
    period = np.diff(starts)
    position = starts[:-1, None] + period[:, None] * np.arange(dense) / dense
    rows: Array = scipy.ndimage.map_coordinates(
        values, position[None], order=SPLINE_ORDER, mode="mirror"
    )
    if dense == n:
        return rows
    spectrum = np.fft.rfft(rows, axis=1)[:, : n // 2 + 1] * (n / dense)
    spectrum[:, -1] = 0.0
    return np.fft.irfft(spectrum, n, axis=1)
