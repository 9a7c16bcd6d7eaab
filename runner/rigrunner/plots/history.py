"""A quantity of many runs over time."""

from __future__ import annotations

from itertools import cycle
from typing import TYPE_CHECKING, Any

from rigrunner.plots.canvas import SERIES, drawn

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from datetime import datetime

    from matplotlib.figure import Figure

    from rigrunner.plots.canvas import Plot

Series = tuple["Sequence[datetime]", "Sequence[float]", "Sequence[float]"]
"""Times, values, and the half-widths of their bars; empty for no bars."""


def history(series: Mapping[str, Series], *, label: str, title: str = "") -> Plot:
    """Return the plot of named series over time, with bars where half-widths are given."""

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for (name, (times, values, bars)), (color, marker) in zip(series.items(), cycle(SERIES)):
            when: Any = times  # matplotlib takes times, its types do not know
            axes.errorbar(
                when, values, bars or None, label=name, linestyle="", color=color, marker=marker
            )
        axes.set(title=title, ylabel=label)
        figure.autofmt_xdate()
        if len(series) > 1:
            axes.legend()

    return drawn(paint)
