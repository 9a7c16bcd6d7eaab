"""A stored run in a notebook: its samples, results and plots."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api.errors import UsageError
from rigrunner.plots import draw
from rigrunner.runfile import read
from rigrunner.signal.recording_figures import of_recording
from rigrunner_fleet.archive.rows import imported
from rigrunner_fleet.notebook.rows import figures_of, plot_of, points_of, results_of, results_plot

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import pandas as pd
    import xarray as xr

    from rigrunner.api.coordinates import Coordinate
    from rigrunner.api.data import Array, Measurement, Recording
    from rigrunner.api.readings import Reading
    from rigrunner.plots import Plot
    from rigrunner.runfile import RunHeader, StoredRun
    from rigrunner_fleet.archive import Rows


@dataclass(frozen=True, eq=False)
class Run:
    """A stored run, read whole. Its files are never changed."""

    stored: StoredRun
    """The content of its files."""

    @property
    def header(self) -> RunHeader:
        """Run, procedure and station, inputs, people, versions."""
        return self.stored.header

    @property
    def outcome(self) -> str:
        """How it ended: 'completed', 'aborted' or 'error'."""
        return self.stored.info.outcome

    @property
    def recordings(self) -> Mapping[str, Recording]:
        """The finished recordings by name, in order: channels of shape (n,), in SI units."""
        return {recording.name: recording for recording in self.stored.recordings}

    @property
    def result(self) -> dict[str, Any] | None:
        """The first analysis, as in `result.json`; None without one."""
        document = self.stored.result_document
        return None if document is None else dict(document)

    @property
    def points(self) -> Rows:
        """A row for each set-point of the first analysis, as in the archive."""
        return points_of(self.result)

    @property
    def results(self) -> Rows:
        """A row for each named result, as in the archive."""
        return results_of(self.result)

    @property
    def figures(self) -> Rows:
        """The figures of the rig by the first analysis, as in the archive."""
        return figures_of(self.result)

    def recording(self, name: str) -> Recording:
        """Return a recording; raise UsageError for an unknown name."""
        if name not in self.recordings:
            raise UsageError(
                f"there is no recording '{name}' in {self.header.run_id}",
                hint=f"there are: {', '.join(self.recordings)}",
            )
        return self.recordings[name]

    def to_pandas(self, recording: str) -> pd.DataFrame:
        """Return the samples of a recording over `time_s`, units in `attrs`; needs pandas."""
        return frame_of(self.recording(recording))

    def to_xarray(self, recording: str) -> xr.Dataset:
        """Return the same as a dataset, with set-points and conditions in `attrs`."""
        return set_of(self.recording(recording))

    def measurements(self, name: str) -> pd.DataFrame:
        """Return the table of the `measure` steps of that name; needs pandas."""
        return frame_of_measurements(self.stored.measurements, name)

    def plot_results(self, name: str) -> Plot:
        """Return the figures of a named result, as in the report; raise UsageError."""
        return results_plot(self.result, name)

    def plot(self, recording: str = "") -> Plot:
        """Return torque over frequency, or the samples of a recording over time."""
        if not recording:
            return plot_of(self.result, self.header.run_id)
        return draw(of_recording(self.recording(recording)))


def open_run(path: Path | str) -> Run:
    """Open a run folder, sealed or not, or a `run.h5`; raise DataError.

    A run that changed after sealing is refused.
    """
    return Run(read(Path(path)))


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
    facts = {**recording.conditions, **recording.setpoints, **recording.coordinates}
    if recording.elapsed_s is not None:
        facts["elapsed_s"] = recording.elapsed_s
    if recording.cycles is not None:
        facts["cycles"] = recording.cycles
    attributes = {"recording": recording.name, "rate_hz": recording.rate_hz, **facts}
    time_s = (TIME, _time_s(recording), {"units": "s"})
    dataset: xr.Dataset = xarray.Dataset(channels, {TIME: time_s}, attributes)
    return dataset


def frame_of_measurements(measurements: Sequence[Measurement], name: str) -> pd.DataFrame:
    """Return the rows of one name: time, coordinates, set-points, values, all in SI units.

    `attrs` has the units by name, and as `shown_in` the display units. Raises UsageError if there
    is none.
    """
    rows = [row for row in measurements if row.name == name]
    if not rows:
        names = ", ".join(dict.fromkeys(row.name for row in measurements)) or "none"
        raise UsageError(f"nothing was measured as '{name}'", hint=f"there are: {names}")
    pandas = imported("pandas")
    frame: pd.DataFrame = pandas.DataFrame([_cells(row) for row in rows])
    frame.attrs["units"] = {key: unit for row in rows for key, unit in row.units.items()}
    frame.attrs["shown_in"] = {key: unit for row in rows for key, unit in row.written_in.items()}
    return frame


def _cells(row: Measurement) -> dict[str, Coordinate | Reading | None]:
    setpoints = {f"set {name}": value for name, value in row.setpoints.items()}
    times: dict[str, Coordinate | None] = {"utc": row.utc, "elapsed_s": row.elapsed_s}
    if row.cycles is not None:
        times["cycles"] = row.cycles
    return {**times, **row.coordinates, **setpoints, **dict(row.values), **row.readings}


def _time_s(recording: Recording) -> Array:
    return np.arange(recording.samples) / recording.rate_hz
