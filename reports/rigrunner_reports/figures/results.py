"""Results over a coordinate, with their expanded uncertainty and the limits."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.figures import Picture
from rigrunner.signal.result_figures import over_coordinate as figures_over
from rigrunner.signal.thinning import places_of_extremes
from rigrunner_reports.numbers import stated

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import MeasurementResult
    from rigrunner.api.figures import Figure, Series
    from rigrunner.api.verdict import LimitDecision


MOST_POINTS = 100
"""The most set-points that are drawn."""
THINNED = (
    " Of the many set-points, those of the least and the greatest values in equal stretches are "
    "drawn; result.json has all."
)


def over_coordinate(
    results: Sequence[MeasurementResult], parts: Sequence[LimitDecision]
) -> tuple[Picture, ...]:
    """Return the figures of results of one name; none if no coordinate is a number."""
    part_of = {id(part.result): part for part in parts}
    points = []
    for result in results:
        part = part_of.get(id(result.estimate))
        limits = None if part is None else part.limits
        points.append((result, limits, part is not None and not part.passes))
    alt = "; ".join(
        f"{result.place}: {stated(result.estimate)}" for result in results[:MOST_POINTS]
    )
    pictures = []
    for figure in figures_over(points):
        shown = replace(figure, series=tuple(map(_thin, figure.series)))
        caption = f"{figure.title} over {figure.x.name}. The bars are U for 95 %."
        caption += " The dashed lines are the limits." if figure.has_limits else ""
        caption += THINNED if shown != figure else ""
        pictures.append(Picture(caption, alt, (shown,)))
    return tuple(pictures)


def picture_of(figure: Figure) -> Picture:
    """Return a figure of an analysis as a picture."""
    alt = "; ".join(
        f"{series.name}: {figure.y} from {min(y):.4g} to {max(y):.4g}"
        for series in figure.series
        if (y := [point.y for point in series.points])
    )
    return Picture(figure.caption or figure.title, alt, (figure,))


def _thin(series: Series) -> Series:
    values = np.array([point.y for point in series.points])
    places = places_of_extremes(values, most=MOST_POINTS)
    return replace(series, points=tuple(series.points[place] for place in places))
