"""Figures of recordings and of tables of measured values."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.coordinates import written_text
from rigrunner.api.figures import Axis, Figure, Picture, Series
from rigrunner.api.units import unit as unit_of
from rigrunner.signal.thinning import places_of_extremes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.data import Array, Measurement, Recording

MOST_SAMPLES = 1500
"""The most samples of a channel that are drawn: more than a figure has pixels."""
MOST_CHANNELS = 6
LEAST_ROWS = 2
"""The fewest rows that are drawn."""
THINNED = " Of many samples the least and the greatest of equal stretches are drawn."


def of_recording(recording: Recording) -> Picture:
    """Return the picture of a recording: each channel over time, one above the other."""
    time, units, written_in = Axis("time", "s"), recording.units, recording.written_in
    panels, alt = [], []
    for name, samples in list(recording.channels.items())[:MOST_CHANNELS]:
        values, unit = _in_unit(np.asarray(samples), units.get(name, ""), written_in.get(name, ""))
        places = places_of_extremes(values, most=MOST_SAMPLES)
        series = Series.over(places / recording.rate_hz, values[places], kind="line")
        panels.append(Figure("", time, Axis(name, unit), (series,)))
        alt.append(_span(name, values, unit))
    where = ", ".join(
        f"{name} {written_text(value, units.get(name, ''), written_in.get(name, ''))}"
        for name, value in recording.setpoints.items()
    )
    more = len(recording.channels) - len(panels)
    left_out = f" {more} more channels are not drawn." if more else ""
    caption = f"Recording {recording.name}{f' at {where}' if where else ''}.{left_out}"
    thinned = THINNED if recording.samples > MOST_SAMPLES else ""
    return Picture(caption + thinned, "; ".join(alt), tuple(panels))


def of_table(rows: Sequence[Measurement]) -> Picture | None:
    """Return the picture of a table over what was set first of several values; None for none."""
    if len(rows) < LEAST_ROWS or not rows[0].values:
        return None
    units = rows[0].units
    varied = (n for n in rows[0].setpoints if len({row.setpoints.get(n) for row in rows}) > 1)
    axis = next(varied, "")
    over = Axis("row")
    panels, alt = [], []
    for name in list(rows[0].values)[:MOST_CHANNELS]:
        drawn = [row for row in rows if name in row.values and (not axis or axis in row.setpoints)]
        measured = np.array([row.values[name] for row in drawn])
        values, unit = _in_unit(measured, units.get(name, ""), _common(drawn, name))
        x = np.arange(1.0, len(drawn) + 1)
        if axis:
            set_points = np.array([row.setpoints[axis] for row in drawn], float)
            x, x_unit = _in_unit(set_points, units.get(axis, ""), _common(rows, axis))
            over = Axis(f"set {axis}", x_unit)
        places = places_of_extremes(values, most=MOST_SAMPLES)
        series = Series.over(x[places], values[places], kind="joined")
        panels.append(Figure("", over, Axis(name, unit), (series,)))
        alt.append(_span(name, values, unit))
    caption = f"Table {rows[0].name}, over {axis or 'its rows'}."
    return Picture(caption, "; ".join(alt), tuple(panels))


def _common(rows: Sequence[Measurement], name: str) -> str:
    """Return the unit in which all rows have it written; '' where they differ."""
    written = {row.written_in.get(name, "") for row in rows}
    return written.pop() if len(written) == 1 else ""


def _in_unit(si: Array, si_unit: str, written_in: str) -> tuple[Array, str]:
    """Return values in the unit for display, shape (n,), and that unit."""
    if not written_in:
        return si, si_unit
    unit = unit_of(written_in)
    return unit.from_si(si), unit.symbol


def _span(name: str, values: Array, unit: str) -> str:
    """Return the range of values as text, for people who cannot see the figure."""
    low, high = (
        f"{end:.6g}".replace("-", "\N{MINUS SIGN}") for end in (values.min(), values.max())
    )
    return f"{name}: {low} to {high} {unit}".rstrip()
