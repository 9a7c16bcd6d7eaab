"""Every cycle of every set-point: what was kept, what was rejected."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.figures import Axis, Figure, Mark, Picture, Series
from rigrunner.signal.thinning import places_of_extremes
from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.signal.swings import kept_cycles

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.figures import SeriesKind
    from rigrunner_bearings.api.points import PeakPoint

MILLI = 1e3
FILLED = 0.8
"""Of the room of a set-point, what its cycles take."""
MOST_NAMED, NAMED = 60, 16
"""Of more set-points than MOST_NAMED, the text alternative of the figure lists only NAMED."""
KINDS: dict[str, tuple[SeriesKind, int]] = {
    "peak kept": ("points", 700),
    "peak rejected": ("excluded", 150),
    "swing rejected": ("marked", 150),
}
"""How each kind of mark is drawn, and how many a panel has at most: more would overlap."""
MOST_KEPT = KINDS["peak kept"][1]
THINNED = (
    " Of more swings than can be told apart, the least and the greatest peak of equal stretches of "
    "time are drawn."
)


def cycle_values(runs: Sequence[tuple[str, Sequence[PeakPoint]]]) -> Picture:
    """Return the picture of each cycle's raw peak against their mean, one panel per named run."""
    return Picture(
        caption="Raw peak of every swing, less the mean of the kept ones, in the order of time "
        "within each set-point. A cross is a peak that the outlier rule rejected; a square is a "
        "swing whose whole shape it rejected, which waveform methods leave out."
        + (THINNED if any(_cycles(points) > MOST_KEPT for _, points in runs) else ""),
        alt=" ".join(_alt(title, points) for title, points in runs),
        panels=tuple(_panel(title, points) for title, points in runs),
    )


def _panel(title: str, points: Sequence[PeakPoint]) -> Figure:
    x = np.concatenate(
        [
            place + FILLED * ((np.arange(point.cycles) + 0.5) / point.cycles - 0.5)
            for place, point in enumerate(points)
        ]
    )
    y = np.concatenate(
        [MILLI * (point.peak_nm - point.peak_nm[point.peak_kept].mean()) for point in points]
    )
    kept = np.concatenate([point.peak_kept for point in points])
    # All swings take part where no shape was judged.
    swing_kept = np.concatenate(
        [
            kept_cycles(point) if isinstance(point, SwingPoint) else np.ones(point.cycles, bool)
            for point in points
        ]
    )
    drawn = []
    for mask, (name, (kind, most)) in zip((kept, ~kept, ~swing_kept), KINDS.items(), strict=True):
        shown = np.flatnonzero(mask)[places_of_extremes(y[mask], most=most)]
        drawn.append(Series.over(x[shown], y[shown], name, kind))
    names = tuple((float(i), f"{p.set_frequency_hz:g} Hz") for i, p in enumerate(points))
    return Figure(
        title,
        Axis("set frequency", ticks=names),
        Axis("peak \N{MINUS SIGN} mean", "mN·m"),
        tuple(series for series in drawn if series.points),
        (Mark("y", 0.0),),
    )


def _cycles(points: Sequence[PeakPoint]) -> int:
    return sum(point.cycles for point in points)


def _alt(title: str, points: Sequence[PeakPoint]) -> str:
    named_points = points
    if len(points) > MOST_NAMED:
        kept = sum(int(point.peak_kept.sum()) for point in points)
        title += f", peaks kept: {kept} of {_cycles(points)}; the most were rejected at"
        named_points = sorted(points, key=lambda point: point.peak_kept.mean())[:NAMED]
    else:
        title += ", peaks kept:"
    counts = ", ".join(
        f"{point.set_frequency_hz:g} Hz {int(point.peak_kept.sum())} of {point.cycles}"
        for point in named_points
    )
    return f"{title} {counts}."
