"""A stored run in a notebook: its samples, results and plots."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import UsageError
from rigrunner.plots import draw
from rigrunner.runfile import read
from rigrunner.signal.recording_figures import of_recording
from rigrunner_fleet.notebook.found import figures_of, plot_of, points_of, results_of, results_plot
from rigrunner_fleet.notebook.frames import frame_of, frame_of_measurements, set_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd
    import xarray as xr

    from rigrunner.api.data import Recording
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
        return {each.name: each for each in self.stored.recordings}

    @property
    def result(self) -> dict[str, Any] | None:
        """The first analysis, as in `result.json`; None without one."""
        found = self.stored.result_document
        return None if found is None else dict(found)

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
