"""Every cycle of every set-point: what was kept, what was rejected."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api.analysis import SwingPoint
from rigrunner.signal.swings import kept_cycles
from rigrunner_reports.plots.canvas import BLUE, GREY, INK, VERMILION, Plot, draw
from rigrunner_reports.plots.thinning import places_of_extremes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rigrunner.api.analysis import PeakPoint
    from rigrunner.api.data import Array, Mask

MILLI = 1e3
FILLED = 0.8
"""Of the room of a set-point, what its cycles take."""
LETTERS, GAP = 112, 2
"""What there is room for under a panel."""
MOST_SAID, SAID = 60, 16
"""Of more set-points than the one, the text that stands for the figure names but the other."""
LOOKS: dict[str, tuple[int, dict[str, Any]]] = {
    "peak kept": (700, {"marker": "o", "color": BLUE, "markersize": 2.6}),
    "peak rejected": (150, {"marker": "x", "color": VERMILION, "markersize": 6}),
    "swing rejected": (
        150,
        {"marker": "s", "color": INK, "markersize": 7, "markerfacecolor": "none"},
    ),
}
"""How many marks a panel has at most of each kind: no eye tells more apart; and their look."""
THINNED = (
    " Of more swings than can be told apart, the least and the greatest peak of equal stretches of "
    "time are drawn."
)


def cycle_values(runs: Sequence[tuple[str, Sequence[PeakPoint]]]) -> Plot:
    """Return the figure of each cycle's raw peak against their mean, one panel per named run."""

    def paint(figure: Figure) -> None:
        panels = figure.subplots(len(runs), 1, squeeze=False)[:, 0]
        for axes, (title, points) in zip(panels, runs, strict=True):
            _panel(axes, title, points)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))

    return Plot(
        caption="Raw peak of every swing, less the mean of the kept ones, in the order of time "
        "within each set-point. A cross is a peak that the outlier rule rejected; a square is a "
        "swing whose whole shape it rejected, which waveform methods leave out."
        + (THINNED if any(_cycles(points) > LOOKS["peak kept"][0] for _, points in runs) else ""),
        alt=" ".join(_alt(title, points) for title, points in runs),
        svg=draw(paint, 0.5 + 1.9 * len(runs)),
    )


def _panel(axes: Axes, title: str, points: Sequence[PeakPoint]) -> None:
    series = [_series(place, point) for place, point in enumerate(points)]
    x, y = (np.concatenate(each) for each in zip(*series, strict=True))
    kept = np.concatenate([point.peak_kept for point in points])
    whole = np.concatenate([_kept_swings(point) for point in points])
    for which, (label, (most, look)) in zip((kept, ~kept, ~whole), LOOKS.items(), strict=True):
        shown = np.flatnonzero(which)[places_of_extremes(y[which], most=most)]
        axes.plot(x[shown], y[shown], label=label, linestyle="", **look)
    axes.axhline(0, color=GREY, linewidth=0.6)
    axes.set(title=title, ylabel="(peak - mean) / mN·m".replace("-", "\N{MINUS SIGN}"))
    _name(axes, [f"{point.set_frequency_hz:g} Hz" for point in points])
    axes.grid(visible=False, axis="x")


def _name(axes: Axes, names: Sequence[str]) -> None:
    """Name the set-points under the panel: as many, evenly, as stand clear of each other."""
    room = LETTERS // (GAP + max(map(len, names)))
    shown = range(0, len(names), -(-len(names) // room))
    axes.set_xticks(shown, [names[place] for place in shown])


def _series(place: int, point: PeakPoint) -> tuple[Array, Array]:
    offset = (np.arange(point.cycles) + 0.5) / point.cycles - 0.5
    mean = point.peak_nm[point.peak_kept].mean()
    return place + FILLED * offset, MILLI * (point.peak_nm - mean)


def _kept_swings(point: PeakPoint) -> Mask:
    """Return which swings take part, shape (cycles,): all of them where no shape was judged."""
    return kept_cycles(point) if isinstance(point, SwingPoint) else np.ones(point.cycles, bool)


def _cycles(points: Sequence[PeakPoint]) -> int:
    return sum(point.cycles for point in points)


def _alt(title: str, points: Sequence[PeakPoint]) -> str:
    said = points
    if len(points) > MOST_SAID:
        kept = sum(int(point.peak_kept.sum()) for point in points)
        title += f", peaks kept: {kept} of {_cycles(points)}; the most were rejected at"
        said = sorted(points, key=lambda point: point.peak_kept.mean())[:SAID]
    else:
        title += ", peaks kept:"
    counts = ", ".join(
        f"{point.set_frequency_hz:g} Hz {int(point.peak_kept.sum())} of {point.cycles}"
        for point in said
    )
    return f"{title} {counts}."
