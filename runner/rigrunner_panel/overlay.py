"""Several stored runs in one figure: results over a coordinate, and a channel over time."""

from __future__ import annotations

from collections import defaultdict
from itertools import pairwise
from math import nan
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api.figures import Axis, Figure, Series
from rigrunner.api.units import unit
from rigrunner.run.set_points import coordinates_in, named_place, results_in

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.data import Array, Recording, Samples
    from rigrunner.runfile import StoredRun

Columns = tuple[list[float], list[float], list[float]]
Pair = tuple[float, float | None]
"""A value and its U, where that is known."""
COLUMNS = 500
"""Number of columns of a channel over time; each shows its lowest and highest sample."""


def result_figures(runs: Mapping[str, StoredRun]) -> Iterator[Figure]:
    """Yield a figure of each named result over a coordinate."""
    figures: dict[tuple[str, Axis, Axis], list[Series]] = defaultdict(list)
    for name, run in runs.items():
        for key, (at, values, half) in _result_columns(run).items():
            figures[key].append(Series.over(at, values, name, "joined", half))
    for (title, x, y), series in figures.items():
        yield Figure(title, x, y, tuple(series))


def result_rows(runs: Mapping[str, StoredRun]) -> list[tuple[str, str, dict[str, Pair]]]:
    """Return each named result that is in no figure: name with place, unit, value and U by run."""
    rows: dict[tuple[str, str], dict[str, Pair]] = defaultdict(dict)
    for name, run in runs.items():
        for result in results_in(run.result_document or {}):
            estimate = result["estimate"]
            if _axis(result) is None and estimate["value"] is not None:
                pair = estimate["value"], estimate["expanded_uncertainty_95"]
                rows[named_place(result), estimate["unit"]][name] = pair
    return [(*key, values) for key, values in rows.items()]


def channel_figure(runs: Mapping[str, StoredRun], recording: str, channel: str) -> Figure | None:
    """Return a channel of the recordings with that name over time; None if no run has it."""
    series, symbol = [], ""
    for name, run in runs.items():
        for candidate in run.recordings:
            if candidate.name == recording and channel in candidate.channels:
                symbol = symbol or candidate.written_in.get(channel) or candidate.units[channel]
                series.append(_envelope(name, candidate, channel, symbol))
    if not series:
        return None
    x, y = Axis("time since the recording began", "s"), Axis(channel, symbol)
    return Figure(channel, x, y, tuple(series))


def channels_in(runs: Mapping[str, StoredRun]) -> dict[str, list[str]]:
    """Return the channels of each recording in any of the runs, by recording name."""
    recordings: dict[str, dict[str, None]] = defaultdict(dict)
    for run in runs.values():
        for recording in run.recordings:
            recordings[recording.name] |= dict.fromkeys(recording.channels)
    return {name: list(channels) for name, channels in recordings.items()}


def _result_columns(run: StoredRun) -> dict[tuple[str, Axis, Axis], Columns]:
    """Return x, y and U of each named result whose first numeric coordinate is x."""
    columns: dict[tuple[str, Axis, Axis], Columns] = {}
    for result in results_in(run.result_document or {}):
        coordinate = _axis(result)
        estimate = result["estimate"]
        if coordinate is None or estimate["value"] is None:
            continue
        axes = Axis(coordinate[0], coordinate[1].unit), Axis(result["name"], estimate["unit"])
        x, y, half = columns.setdefault((result["name"], *axes), ([], [], []))
        x.append(float(coordinate[1].value))
        y.append(estimate["value"])
        expanded = estimate["expanded_uncertainty_95"]
        half.append(nan if expanded is None else float(expanded))
    return columns


def _axis(result: Mapping[str, Any]) -> tuple[str, CoordinateValue] | None:
    """Return the first numeric coordinate of a named result, with its name."""
    places = coordinates_in(result).items()
    return next(((key, value) for key, value in places if isinstance(value.value, float)), None)


def _envelope(name: str, recording: Recording, channel: str, symbol: str) -> Series:
    """Return a channel over time: all samples, or the lowest and highest of each column."""
    samples, count = recording.channels[channel], recording.samples
    if count <= 2 * COLUMNS:
        time_s = np.arange(count) / recording.rate_hz
        return Series.over(time_s, _shown(samples, 0, count, symbol), name, "line")
    edges = np.linspace(0, count, COLUMNS + 1).astype(int)
    x, y = [], []
    for first, last in pairwise(edges):
        piece = _shown(samples, int(first), int(last), symbol)
        x += 2 * [float(first) / recording.rate_hz]
        y += [float(piece.min()), float(piece.max())]
    return Series.over(x, y, name, "line")


def _shown(samples: Samples, first: int, last: int, symbol: str) -> Array:
    written_in = unit(symbol)
    return (np.asarray(samples[first:last]) - written_in.offset) / written_in.factor
