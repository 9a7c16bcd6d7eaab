"""The figure of a control chart: the values with their limits, and below it their differences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner_reports.plots.canvas import BLUE, GREY, INK, VERMILION, Plot, draw
from rigrunner_reports.plots.thinning import places_of_extremes
from rigrunner_reports.studies.numbers import as_scattered

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rigrunner.api.data import Array
    from rigrunner.api.studies import ChartPoint, Trend, TrendSeries

MOST = 400
"""Points that are drawn; no eye tells more apart."""
MOST_WITH_BARS = 120
"""With more, bars of uncertainty would be a band."""
_DASHED = (0, (6, 3))
ROOM = 0.075
"""Of the height of a panel, what a line of text beside it takes."""


def control_chart(trend: Trend, series: TrendSeries) -> Plot:
    """Return the figure of one series, a run's number in the series across."""
    weighted = trend.chart == "ewma"
    shown = _shown(series)

    def paint(figure: Figure) -> None:
        rows = 1 if weighted else 2
        panels = figure.subplots(rows, 1, sharex=True, squeeze=False, height_ratios=(2, 1)[:rows])
        upper, lower = panels[0, 0], panels[-1, 0]
        _values(upper, series, shown, weighted=weighted)
        upper.set(
            ylabel=f"value / {trend.unit}",
            title="Weighted mean of the values" if weighted else "Values",
        )
        if not weighted:
            _ranges(lower, series, shown)
            lower.set(ylabel=f"difference / {trend.unit}", title="Moving range")
        lower.set(xlabel="run", xlim=(0, len(series.points) + 1))
        handles, labels = upper.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=4)

    height_in = 3.3 if weighted else 4.6
    caption = _caption(series, weighted=weighted)
    return Plot(caption=caption, alt=_alt(series), svg=draw(paint, height_in))


def _shown(series: TrendSeries) -> list[int]:
    """Return the places to draw: all, or of very many the extremes, also of those with a rule."""
    values = np.array([each.observed.value for each in series.points])
    plotted = np.array([each.plotted for each in series.points])
    met = np.flatnonzero([bool(each.rules) for each in series.points])
    drawn = met[places_of_extremes(plotted[met], most=MOST)].tolist()
    return sorted({*places_of_extremes(values, plotted, most=MOST).tolist(), *drawn})


def _values(axes: Axes, series: TrendSeries, shown: list[int], *, weighted: bool) -> None:
    points = series.points
    number = np.array(shown) + 1
    if weighted:
        single = [points[place].observed.value for place in shown]
        axes.plot(number, single, ".", color=GREY, markersize=4, label="single value")
    elif len(shown) <= MOST_WITH_BARS:
        _bars(axes, points, shown)
    plotted = np.array([points[place].plotted for place in shown])
    label = "weighted mean" if weighted else "value"
    axes.plot(number, plotted, "o-", color=BLUE, linewidth=0.9, markersize=3.5, label=label)
    _met(axes, points, shown, plotted)
    _limits(axes, series)
    _baseline(axes, points)


def _bars(axes: Axes, points: tuple[ChartPoint, ...], shown: list[int]) -> None:
    stated = [(place, points[place].observed) for place in shown]
    known = [(place + 1, each) for place, each in stated if each.expanded is not None]
    if known:
        axes.errorbar(
            [number for number, _ in known],
            [each.value for _, each in known],
            yerr=[each.expanded or 0.0 for _, each in known],
            fmt="none",
            ecolor="#B9C6D3",
            elinewidth=1,
            capsize=0,
            zorder=1,
            label="stated U (95 %)",
        )


def _met(axes: Axes, points: tuple[ChartPoint, ...], shown: list[int], plotted: Array) -> None:
    met = [index for index, place in enumerate(shown) if points[place].rules]
    if met:
        axes.plot(
            [shown[index] + 1 for index in met],
            plotted[met],
            linestyle="",
            marker="s",
            markersize=8,
            markerfacecolor="none",
            markeredgewidth=1.5,
            color=VERMILION,
            label="a rule is met",
        )


def _limits(axes: Axes, series: TrendSeries) -> None:
    number = np.arange(1, len(series.points) + 1)
    axes.axhline(series.individuals.centre, color=INK, linewidth=0.8)
    for name in ("lower", "upper"):
        limit = [getattr(each, name) for each in series.points]
        axes.step(number, limit, where="mid", color=INK, linewidth=1.1, linestyle=_DASHED)
    last = series.points[-1]
    _name(axes, (last.lower, series.individuals.centre, last.upper), series.individuals.sigma)


def _name(axes: Axes, values: tuple[float, ...], sigma: float) -> None:
    """Write values beside the axes, at their heights; in one line where there is no room."""
    low, high = axes.get_ylim()
    texts = [(value, as_scattered(value, sigma)) for value in values]
    if values[-1] - values[0] < ROOM * (len(values) - 1) * (high - low):
        texts = [(sum(values) / len(values), f"{texts[0][1]} to\n{texts[-1][1]}")]
    for value, text in texts:
        axes.annotate(
            text,
            (1, value),
            xycoords=("axes fraction", "data"),
            xytext=(4, 0),
            textcoords="offset points",
            fontsize=7.5,
            va="center",
        )


def _baseline(axes: Axes, points: tuple[ChartPoint, ...]) -> None:
    places = [place for place, each in enumerate(points, 1) if each.baseline]
    label = "baseline"
    axes.axvspan(places[0] - 0.5, places[-1] + 0.5, color="#EAF3F9", zorder=0, label=label)


def _ranges(axes: Axes, series: TrendSeries, shown: list[int]) -> None:
    known = [(place + 1, series.points[place].moving_range) for place in shown]
    drawn = [(number, each) for number, each in known if each is not None]
    axes.plot(*np.transpose(drawn), "o-", color=BLUE, linewidth=0.9, markersize=3)
    limits = series.moving_range
    axes.axhline(limits.centre, color=INK, linewidth=0.8)
    axes.axhline(limits.upper, color=INK, linewidth=1.1, linestyle=_DASHED)
    axes.set_ylim(bottom=0)
    _name(axes, (limits.centre, limits.upper), series.individuals.sigma)


def _caption(series: TrendSeries, *, weighted: bool) -> str:
    what = (
        "Exponentially weighted mean of the values, with its limits, which widen to their last "
        "width"
        if weighted
        else "Values of the runs in the order of time, between three standard deviations"
    )
    below = "" if weighted else " Below: how far each run is from the one before, with its limit."
    thinned = (
        " Of the many runs, and of those at which a rule is met, the least and the greatest of "
        "equal stretches are drawn."
        if len(series.points) > MOST
        else ""
    )
    return (
        f"{series.name}. {what}. The limits are made of the baseline, on the blue ground, alone."
        + below
        + thinned
    )


def _alt(series: TrendSeries) -> str:
    limits = series.individuals
    sigma = limits.sigma
    met = ", ".join(f"{each.observed.run_id} ({', '.join(each.rules)})" for each in series.alarms)
    return (
        f"{len(series.points)} values about {as_scattered(limits.centre, sigma)}, limits "
        f"{as_scattered(series.points[-1].lower, sigma)} and "
        f"{as_scattered(series.points[-1].upper, sigma)}. "
        f"Rules met after the baseline: {met or 'none'}."
    )
