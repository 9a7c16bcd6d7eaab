"""Recordings over time, and tables over what was set: what was recorded, for the eye."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner_reports.plots.canvas import BLUE, Plot, draw
from rigrunner_reports.plots.results import span_text
from rigrunner_reports.plots.thinning import places_of_extremes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from rigrunner.api.data import Array, Measurement, Recording

MOST_SAMPLES = 1500
MOST_CHANNELS = 6
PANEL_IN = 1.3
Series = tuple[str, "Array", "Array"]


def recorded_curves(recording: Recording) -> Plot:
    """Return the figure of a recording: each channel over time, one above the other."""
    panels: list[Series] = []
    alt = []
    for name, samples in list(recording.channels.items())[:MOST_CHANNELS]:
        values, unit = np.asarray(samples), recording.units.get(name, "")
        places = places_of_extremes(values, most=MOST_SAMPLES)
        panels.append((f"{name}\n{unit}", places / recording.rate_hz, values[places]))
        alt.append(f"{name}: {span_text(values, unit)}")
    where = ", ".join(
        f"{name} {value:.6g} {recording.units.get(name, '')}".rstrip()
        for name, value in recording.setpoints.items()
    )
    more = len(recording.channels) - len(panels)
    left_out = f" {more} more channels are not drawn." if more else ""
    thinned = " Of many samples the least and the greatest of equal stretches are drawn."
    caption = f"Recording {recording.name}{f' at {where}' if where else ''}.{left_out}"
    if recording.samples > MOST_SAMPLES:
        caption += thinned
    return Plot(caption, "; ".join(alt), _stacked(panels, "time / s"))


def table_curves(rows: Sequence[Measurement]) -> Plot | None:
    """Return the figure of a table over what was set first of several values; None for none."""
    if len(rows) < 2 or not rows[0].values:  # noqa: PLR2004  (one point is no curve)
        return None
    axis = next(
        (name for name in rows[0].setpoints if len({r.setpoints.get(name) for r in rows}) > 1), ""
    )
    panels: list[Series] = []
    alt = []
    for name in list(rows[0].values)[:MOST_CHANNELS]:
        found = [row for row in rows if name in row.values and (not axis or axis in row.setpoints)]
        values, unit = np.array([row.values[name] for row in found]), rows[0].units.get(name, "")
        x = (
            np.array([row.setpoints[axis] for row in found])
            if axis
            else np.arange(1, len(found) + 1)
        )
        places = places_of_extremes(values, most=MOST_SAMPLES)
        panels.append((f"{name}\n{unit}", np.asarray(x, float)[places], values[places]))
        alt.append(f"{name}: {span_text(values, unit)}")
    label = f"set {axis} / {rows[0].units.get(axis) or '1'}" if axis else "row"
    caption = f"Table {rows[0].name}, over {axis or 'its rows'}."
    return Plot(caption, "; ".join(alt), _stacked(panels, label, mark="o"))


def _stacked(panels: Sequence[Series], label: str, mark: str = "") -> bytes:
    def paint(figure: Figure) -> None:
        rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)
        for (axes,), (name, x, y) in zip(rows, panels, strict=True):
            axes.plot(x, y, color=BLUE, linewidth=1.0, marker=mark or None)
            axes.set_ylabel(name)
        rows[-1, 0].set_xlabel(label)

    return draw(paint, 0.7 + PANEL_IN * len(panels))
