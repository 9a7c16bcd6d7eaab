"""Figures that analyses give as data."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner_reports.plots.canvas import INK, OTHERS, PRIMARY, Plot, draw

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing

    from rigrunner.api.findings import Figure, Panel

HEIGHT_IN, NEXT_IN = 2.8, 1.3
BAND_OPACITY = 0.15


def drawn(figure: Figure) -> Plot:
    """Return a figure drawn: panels over one x, the first of them the highest."""
    count = len(figure.panels)

    def paint(drawing: Drawing) -> None:
        heights = (2.0, *(1.0,) * (count - 1))
        grid = drawing.subplots(count, 1, sharex=True, height_ratios=heights, squeeze=False)
        for axes, panel in zip(grid[:, 0], figure.panels, strict=True):
            _paint(axes, panel)
        grid[-1, 0].set(xlabel=figure.x)
        handles, labels = grid[0, 0].get_legend_handles_labels()
        if len(labels) > 1:
            drawing.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4))

    alt = "; ".join(
        f"{each.name}: {panel.y} from {min(each.y):.4g} to {max(each.y):.4g}"
        for panel in figure.panels
        for each in panel.series
    )
    return Plot(figure.caption, alt, draw(paint, HEIGHT_IN + NEXT_IN * (count - 1)))


def _paint(axes: Axes, panel: Panel) -> None:
    for each, style in zip(panel.series, (PRIMARY, *OTHERS) * len(panel.series), strict=False):
        x, y = np.array(each.x), np.array(each.y)
        if not each.line:
            axes.errorbar(x, y, yerr=each.U or None, fmt="o", color=INK, label=each.name)
            continue
        axes.plot(x, y, color=style.color, linestyle=style.linestyle, label=each.name)
        if each.U:
            half = np.array(each.U)
            axes.fill_between(
                x, y - half, y + half, color=style.color, alpha=BAND_OPACITY, linewidth=0
            )
    axes.set(ylabel=panel.y)
