"""How results moved, drawn: over all runs, and at each set-point."""

from __future__ import annotations

from base64 import b64encode
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.plots.canvas import BLUE, INK, VERMILION, drawn

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rigrunner.golden.overall import Overall

_BINS = 41


def shifts(found: Overall) -> str:
    """Return the figure as the source of an <img>; the same check gives the same bytes."""

    def paint(figure: Figure) -> None:
        left, right = figure.subplots(1, 2)
        _distribution(left, found)
        _frequencies(right, found)

    from matplotlib import rc_context  # noqa: PLC0415  (half a second, for those who plot)

    svg = BytesIO()
    with rc_context({"svg.hashsalt": "rigrunner"}):
        plot = drawn(paint)
        plot.figure.savefig(svg, format="svg", metadata={"Date": None})
    return f"data:image/svg+xml;base64,{b64encode(svg.getvalue()).decode('ascii')}"


def _distribution(axes: Axes, found: Overall) -> None:
    from matplotlib.ticker import MaxNLocator  # noqa: PLC0415  (as above)

    values = np.array(found.shifts_in_u())
    reach = max(float(np.abs(values).max(initial=0)) * 1.1, 1.05)
    edges = np.linspace(-reach, reach, _BINS)
    axes.hist(values, bins=edges.tolist(), color=BLUE)
    axes.axvspan(-1, 1, color=INK, alpha=0.06, linewidth=0)
    axes.set(title="Shift of each result", xlabel="shift / U", ylabel="runs", xlim=(-reach, reach))
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def _frequencies(axes: Axes, found: Overall) -> None:
    points = [each for each in found.by_frequency() if each.in_u is not None]
    hz = [each.frequency_hz for each in points]
    mean = np.array([each.in_u.mean for each in points if each.in_u])
    largest = np.array([each.in_u.largest for each in points if each.in_u])
    axes.axhspan(-1, 1, color=INK, alpha=0.06, linewidth=0)
    axes.axhline(0, color=INK, linewidth=0.8)
    axes.plot(hz, largest, "D", color=VERMILION, linestyle="none", label="largest of any run")
    axes.plot(hz, mean, "o-", color=BLUE, label="mean over the runs")
    axes.set(title="Shift at each set-point", xlabel="frequency / Hz", ylabel="shift / U")
    low, high = axes.get_ylim()
    reach = max(abs(low), abs(high), 1.1)
    axes.set_ylim(-reach, reach)
    axes.legend(loc="best")
