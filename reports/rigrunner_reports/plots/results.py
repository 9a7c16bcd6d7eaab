"""Results over a coordinate, with their expanded uncertainty and the limits."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.plots.results import paint
from rigrunner.signal.result_figures import over_coordinate as figures_over
from rigrunner_reports.numbers import plain, stated
from rigrunner_reports.plots.canvas import Plot, draw
from rigrunner_reports.plots.thinning import MOST_POINTS, THINNED, places_of_extremes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure as Canvas

    from rigrunner.api.data import Array
    from rigrunner.api.figures import Figure, Series
    from rigrunner.api.findings import MeasurementResult
    from rigrunner.api.verdict import LimitDecision


def over_coordinate(
    results: Sequence[MeasurementResult], parts: Sequence[LimitDecision]
) -> tuple[Plot, ...]:
    """Return the figures of results of one name; none where no coordinate is a number."""
    own = {id(part.result): part for part in parts}
    found = []
    for each in results:
        part = own.get(id(each.estimate))
        limits = None if part is None else part.limits
        found.append((each, limits, part is not None and not part.passes))
    alt = "; ".join(f"{each.place}: {stated(each.estimate)}" for each in results[:MOST_POINTS])
    return tuple(_plot(figure, alt) for figure in figures_over(found))


def given(figure: Figure) -> Plot:
    """Return a figure that an analysis gave, drawn."""
    alt = "; ".join(
        f"{each.name}: {figure.y} from {min(y):.4g} to {max(y):.4g}"
        for each in figure.series
        for y in [[point.y for point in each.points]]
    )
    return _drawn(figure, figure.caption or figure.title, alt)


def _plot(figure: Figure, alt: str) -> Plot:
    shown = replace(figure, series=tuple(map(_thinned, figure.series)))
    limits = " The dashed lines are the limits." if figure.has_limits else ""
    caption = f"{figure.title} over {figure.x.name}. The bars are U for 95 %.{limits}"
    thinned = THINNED if shown != figure else ""
    return _drawn(shown, f"{caption}{thinned}", alt)


def _drawn(figure: Figure, caption: str, alt: str) -> Plot:
    def paint_with_legend(canvas: Canvas) -> None:
        axes = canvas.subplots()
        paint(axes, figure)
        handles, labels = axes.get_legend_handles_labels()
        if len(labels) > 1:
            canvas.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4))

    return Plot(caption, alt, draw(paint_with_legend, 3.0))


def _thinned(series: Series) -> Series:
    values = np.array([point.y for point in series.points])
    places = places_of_extremes(values, most=MOST_POINTS)
    return replace(series, points=tuple(series.points[place] for place in places))


def span_text(values: Array, unit: str) -> str:
    """Return the range of values in words, for those who do not see a figure."""
    return f"{plain(float(values.min()))} to {plain(float(values.max()))} {unit}"
