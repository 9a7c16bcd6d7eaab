"""Recordings and measurements as data frames and datasets."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import UsageError
from rigrunner_fleet.archive.extras import imported

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    import xarray as xr

    from rigrunner.api.coordinates import Coordinate
    from rigrunner.api.data import Array, Measurement, Recording
    from rigrunner.api.readings import Reading

TIME = "time_s"


def frame_of(recording: Recording) -> pd.DataFrame:
    """Return the samples over time; `attrs` has the units by channel."""
    pandas = imported("pandas")
    index = pandas.Index(_time_s(recording), name=TIME)
    frame: pd.DataFrame = pandas.DataFrame(recording.arrays(), index=index)
    frame.attrs["units"] = {name: recording.units.get(name, "1") for name in recording.channels}
    return frame


def set_of(recording: Recording) -> xr.Dataset:
    """Return the samples along `time_s`, each channel with its units."""
    xarray = imported("xarray")
    channels = {
        name: (TIME, values, {"units": recording.units.get(name, "1")})
        for name, values in recording.arrays().items()
    }
    told = {**recording.conditions, **recording.setpoints, **recording.coordinates}
    if recording.elapsed_s is not None:
        told["elapsed_s"] = recording.elapsed_s
    if recording.cycles is not None:
        told["cycles"] = recording.cycles
    attributes = {"recording": recording.name, "rate_hz": recording.rate_hz, **told}
    time_s = (TIME, _time_s(recording), {"units": "s"})
    found: xr.Dataset = xarray.Dataset(channels, {TIME: time_s}, attributes)
    return found


def frame_of_measurements(measurements: Sequence[Measurement], name: str) -> pd.DataFrame:
    """Return the rows of one name: time, coordinates, set-points, values, all in SI units.

    `attrs` has the units by name, and as `shown_in` the display units. Raises UsageError if there
    is none.
    """
    rows = [each for each in measurements if each.name == name]
    if not rows:
        names = ", ".join(dict.fromkeys(each.name for each in measurements)) or "none"
        raise UsageError(f"nothing was measured as '{name}'", hint=f"there are: {names}")
    pandas = imported("pandas")
    frame: pd.DataFrame = pandas.DataFrame([_cells(each) for each in rows])
    frame.attrs["units"] = {key: unit for each in rows for key, unit in each.units.items()}
    frame.attrs["shown_in"] = {key: unit for each in rows for key, unit in each.written_in.items()}
    return frame


def _cells(row: Measurement) -> dict[str, Coordinate | Reading | None]:
    setpoints = {f"set {name}": value for name, value in row.setpoints.items()}
    times: dict[str, Coordinate | None] = {"utc": row.utc, "elapsed_s": row.elapsed_s}
    if row.cycles is not None:
        times["cycles"] = row.cycles
    return {**times, **row.coordinates, **setpoints, **dict(row.values), **row.readings}


def _time_s(recording: Recording) -> Array:
    return np.arange(recording.samples) / recording.rate_hz
