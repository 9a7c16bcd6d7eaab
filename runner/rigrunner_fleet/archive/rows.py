"""The rows of a query, for pandas, xarray, files and loops."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from datetime import datetime
from importlib import import_module
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import MissingPackageError, UsageError
from rigrunner.api.figures import Axis, Figure, Picture, Point, Series
from rigrunner.clock import utc_text
from rigrunner.plots import draw
from rigrunner.spreadsheet import cell
from rigrunner_fleet.archive.searching import CONTEXT

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    import pandas as pd
    import xarray as xr

    from rigrunner.plots import Plot

FOLDER = "folder"
"""The column with the path of a run folder, on the machine that indexed it."""
_DTYPES: dict[type, Any] = {float: "float64", datetime: "datetime64[us, UTC]"}
_UNITS = {"nm": "N·m", "hz": "Hz", "n": "N"}
"""The suffixes of column names that stand for units."""
_WITHOUT_NONE: dict[type, Any] = {int: "int64", bool: "bool"}
"""Types in data frames; integers and truth values with unknown entries stay objects there."""


def imported(name: str) -> Any:
    """Import a package of the extra 'export'; raise MissingPackageError."""
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise MissingPackageError(
            f"this needs {error.name}", hint="pip install 'rigrunner[export]'"
        ) from error


@dataclass(frozen=True)
class Rows:
    """Rows of one table of an archive, the oldest run first."""

    table: str
    columns: Mapping[str, type]
    """The name of each column and the type of its values, any of which may be None."""
    values: tuple[tuple[Any, ...], ...]

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.values)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """Yield each row as a mapping of column to value."""
        return (dict(zip(self.columns, row, strict=True)) for row in self.values)

    def column(self, name: str) -> list[Any]:
        """Return the values of one column; raise UsageError for an unknown name."""
        if name not in self.columns:
            raise UsageError(
                f"there is no column '{name}' in {self.table}",
                hint=f"there are: {', '.join(self.columns)}",
            )
        place = list(self.columns).index(name)
        return [row[place] for row in self.values]

    def to_pandas(self) -> pd.DataFrame:
        """Return a data frame; needs pandas."""
        pandas = imported("pandas")
        columns = dict(zip(self.columns, zip(*self.values, strict=True), strict=False))
        frame: pd.DataFrame = pandas.DataFrame(
            {name: pandas.Series(columns.get(name, ()), dtype=object) for name in self.columns}
        )
        dtypes = {}
        for name, kind in self.columns.items():
            exact = {} if None in columns.get(name, ()) else _WITHOUT_NONE
            dtypes[name] = {**_DTYPES, **exact}.get(kind, object)
        return frame.astype(dtypes)

    def to_xarray(self) -> xr.Dataset:
        """Return a dataset; needs xarray and pandas.

        Points have the dimensions `run` and `point`, with NaN where a run has fewer; columns of the
        run have `run` alone; the rows of other tables have `row`.
        """
        imported("xarray")
        frame = self.to_pandas()
        for name in frame.select_dtypes("datetimetz"):
            frame[name] = frame[name].dt.tz_localize(None)  # NumPy's times have no zone: UTC
        if self.table != "points":
            frame.index.name = "row"
            rows: xr.Dataset = frame.to_xarray()
            return rows
        frame = frame.rename(columns={"run_id": "run", "number": "point"})
        if frame.duplicated(["run", "point"]).any():
            raise UsageError("a run is there more than once", hint="leave copies out")
        of_runs = [name for name in (*CONTEXT, FOLDER) if name in frame]
        runs = frame.groupby("run", sort=True)[of_runs].first().to_xarray()
        points: xr.Dataset = frame.drop(columns=of_runs).set_index(["run", "point"]).to_xarray()
        return points.assign_coords(runs.data_vars)

    def plot(self, value: str = "torque_nm", by: str = "rig", bars: str = "expanded_nm") -> Plot:
        """Plot a column over the start of the runs, with a series for each value of another column.

        `bars` names the column of half-widths, if any. Raises UsageError for an unknown column.
        """
        groups: dict[str, list[Point]] = {}
        halves = self.column(bars) if bars in self.columns else [None] * len(self)
        columns = (self.column("started_utc"), self.column(value), self.column(by), halves)
        for started, number, name, half in zip(*columns, strict=True):
            if started is not None and number is not None:
                groups.setdefault(str(name), []).append(Point(started.timestamp(), number, half))
        series = tuple(Series(name, tuple(points)) for name, points in groups.items())
        label, _, suffix = value.rpartition("_")
        axis = Axis(label, _UNITS[suffix]) if suffix in _UNITS else Axis(value)
        title = f"{self.table}, by {by}"
        figure = Figure(title, Axis("start of the run", is_time=True), axis, series)
        return draw(Picture(title, title, (figure,)), titled=True)

    def to_csv(self, path: Path | None = None, *, raw: bool = False) -> str:
        """Return the rows as CSV, and write it to a file if one is named; times are in UTC.

        A value that a spreadsheet would take for a formula gets an apostrophe before it, unless
        `raw`.
        """
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        cells = (map(_cell, row) for row in self.values)
        writer.writerows(cells if raw else (map(cell, row) for row in cells))
        if path is not None:
            try:
                path.write_text(text.getvalue(), encoding="utf-8", newline="")
            except OSError as error:
                raise UsageError(f"{path} cannot be written: {error.strerror}") from error
        return text.getvalue()

    def to_parquet(self, path: Path) -> None:
        """Write the rows to a Parquet file; needs pyarrow."""
        pyarrow = imported("pyarrow")
        parquet = imported("pyarrow.parquet")
        kinds = {
            bool: pyarrow.bool_(),
            int: pyarrow.int64(),
            float: pyarrow.float64(),
            datetime: pyarrow.timestamp("us", "UTC"),
        }
        arrays = [
            pyarrow.array(self.column(name), kinds.get(kind, pyarrow.string()))
            for name, kind in self.columns.items()
        ]
        try:
            parquet.write_table(pyarrow.table(arrays, names=list(self.columns)), path)
        except OSError as error:
            raise UsageError(f"{path} cannot be written: {error.strerror}") from error


def _cell(value: Any) -> Any:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return utc_text(value) if isinstance(value, datetime) else value
