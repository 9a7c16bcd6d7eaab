"""Recordings over time, and tables over what was set: what was recorded, for the eye."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.coordinates import written_text
from rigrunner.api.units import unit as unit_of
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
        values, unit = _shown(np.asarray(samples), recording.units.get(name, ""),
                              recording.written_in.get(name, ""))  # fmt: skip
        places = places_of_extremes(values, most=MOST_SAMPLES)
        panels.append((f"{name}\n{unit}", places / recording.rate_hz, values[places]))
        alt.append(f"{name}: {span_text(values, unit)}")
    where = ", ".join(
        f"{name} {_set_text(recording, name, value)}" for name, value in recording.setpoints.items()
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
        values, unit = _shown(np.array([row.values[name] for row in found]),
                              rows[0].units.get(name, ""), _common(found, name))  # fmt: skip
        x, x_unit = (
            _shown(np.array([row.setpoints[axis] for row in found]),
                   rows[0].units.get(axis, ""), _common(rows, axis))
            if axis
            else (np.arange(1, len(found) + 1), "")
        )  # fmt: skip
        places = places_of_extremes(values, most=MOST_SAMPLES)
        panels.append((f"{name}\n{unit}", np.asarray(x, float)[places], values[places]))
        alt.append(f"{name}: {span_text(values, unit)}")
    label = f"set {axis} / {x_unit or '1'}" if axis else "row"
    caption = f"Table {rows[0].name}, over {axis or 'its rows'}."
    return Plot(caption, "; ".join(alt), _stacked(panels, label, mark="o"))


def _set_text(recording: Recording, name: str, value: float) -> str:
    return written_text(value, recording.units.get(name, ""), recording.written_in.get(name, ""))


def _common(rows: Sequence[Measurement], name: str) -> str:
    """Return the unit in which all rows have it written; '' where they differ."""
    written = {row.written_in.get(name, "") for row in rows}
    return written.pop() if len(written) == 1 else ""


def _shown(si: Array, si_unit: str, written_in: str) -> tuple[Array, str]:
    """Return values in the unit in which people see them, shape (n,), and that unit."""
    if not written_in:
        return si, si_unit
    known = unit_of(written_in)
    return (si - known.offset) / known.factor, known.symbol


def _stacked(panels: Sequence[Series], label: str, mark: str = "") -> bytes:
    def paint(figure: Figure) -> None:
        rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)
        for (axes,), (name, x, y) in zip(rows, panels, strict=True):
            axes.plot(x, y, color=BLUE, linewidth=1.0, marker=mark or None)
            axes.set_ylabel(name)
        rows[-1, 0].set_xlabel(label)

    return draw(paint, 0.7 + PANEL_IN * len(panels))
