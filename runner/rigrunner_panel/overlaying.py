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
    found: dict[tuple[str, Axis, Axis], list[Series]] = defaultdict(list)
    for name, run in runs.items():
        for key, (at, values, half) in _named(run).items():
            found[key].append(Series.over(at, values, name, "joined", half))
    for (title, x, y), series in found.items():
        yield Figure(title, x, y, tuple(series))


def result_rows(runs: Mapping[str, StoredRun]) -> list[tuple[str, str, dict[str, Pair]]]:
    """Return each named result that is in no figure: name with place, unit, value and U by run."""
    found: dict[tuple[str, str], dict[str, Pair]] = defaultdict(dict)
    for name, run in runs.items():
        for each in results_in(run.result_document or {}):
            estimate = each["estimate"]
            if _axis(each) is None and estimate["value"] is not None:
                pair = estimate["value"], estimate["expanded_uncertainty_95"]
                found[named_place(each), estimate["unit"]][name] = pair
    return [(*key, values) for key, values in found.items()]


def channel_figure(runs: Mapping[str, StoredRun], recording: str, channel: str) -> Figure | None:
    """Return a channel of the recordings with that name over time; None if no run has it."""
    series, symbol = [], ""
    for name, run in runs.items():
        for each in run.recordings:
            if each.name == recording and channel in each.channels:
                symbol = symbol or each.written_in.get(channel) or each.units[channel]
                series.append(_envelope(name, each, channel, symbol))
    if not series:
        return None
    x, y = Axis("time since the recording began", "s"), Axis(channel, symbol)
    return Figure(channel, x, y, tuple(series))


def recorded(runs: Mapping[str, StoredRun]) -> dict[str, list[str]]:
    """Return the channels of each recording in any of the runs, by recording name."""
    found: dict[str, dict[str, None]] = defaultdict(dict)
    for run in runs.values():
        for each in run.recordings:
            found[each.name] |= dict.fromkeys(each.channels)
    return {name: list(channels) for name, channels in found.items()}


def _named(run: StoredRun) -> dict[tuple[str, Axis, Axis], Columns]:
    """Return x, y and U of each named result whose first numeric coordinate is x."""
    found: dict[tuple[str, Axis, Axis], Columns] = {}
    for each in results_in(run.result_document or {}):
        at = _axis(each)
        estimate = each["estimate"]
        if at is None or estimate["value"] is None:
            continue
        axes = Axis(at[0], at[1].unit), Axis(each["name"], estimate["unit"])
        x, y, half = found.setdefault((each["name"], *axes), ([], [], []))
        x.append(float(at[1].value))
        y.append(estimate["value"])
        expanded = estimate["expanded_uncertainty_95"]
        half.append(nan if expanded is None else float(expanded))
    return found


def _axis(result: Mapping[str, Any]) -> tuple[str, CoordinateValue] | None:
    """Return the first numeric coordinate of a named result, with its name."""
    places = coordinates_in(result).items()
    return next(((key, at) for key, at in places if isinstance(at.value, float)), None)


def _envelope(name: str, recording: Recording, channel: str, symbol: str) -> Series:
    """Return a channel over time: all samples, or the lowest and highest of each column."""
    samples, count = recording.channels[channel], recording.samples
    if count <= 2 * COLUMNS:
        at = np.arange(count) / recording.rate_hz
        return Series.over(at, _shown(samples, 0, count, symbol), name, "line")
    edges = np.linspace(0, count, COLUMNS + 1).astype(int)
    x, y = [], []
    for first, last in pairwise(edges):
        piece = _shown(samples, int(first), int(last), symbol)
        x += 2 * [float(first) / recording.rate_hz]
        y += [float(piece.min()), float(piece.max())]
    return Series.over(x, y, name, "line")


def _shown(samples: Samples, first: int, last: int, symbol: str) -> Array:
    known = unit(symbol)
    return (np.asarray(samples[first:last]) - known.offset) / known.factor
