"""Set-points and labels are shown in the units of the procedure."""

from __future__ import annotations

import h5py
import pytest

from helpers_cli import call
from helpers_tester import STATION, run
from rigrunner.api.coordinates import (
    coordinates_text,
    measured_column,
    number_text,
    written_column,
    written_text,
)
from rigrunner.api.data import Measurement
from rigrunner.api.units import from_si, unit
from rigrunner.runfile import read

PROCEDURE = """\
rigrunner: procedure/2
id: WRITTEN
revision: "A"
title: As it is written
uses: {tester: tester}
main:
  - set: {tester.load: 0.5 kN, tester.frequency: 10 Hz}
  - group:
      label: {dwell: 2 min, room: 21 °C, preload: 8 in·lbf}
      steps:
        - record: {channels: [tester.angle, tester.torque], duration: 0.5 s}
        - measure: {channels: [tester.load], limits: {tester.load: {max: 1 kN}}}
teardown:
  - set: {tester.frequency: 0 Hz, tester.load: 0 N}
"""
pytestmark = pytest.mark.usefixtures("tester")
WRITTEN = {"tester.load": "kN", "dwell": "min", "room": "°C", "preload": "in·lbf"}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("written")
    (folder / "p.yaml").write_text(PROCEDURE, encoding="utf-8")
    return run(folder / "p.yaml", folder / "runs")


def test_numbers_are_in_si_with_units_of_procedure(finished):
    stored = read(finished.folder)
    for part in (*stored.recordings, *stored.measurements):
        assert part.setpoints["tester.load"] == 500.0
        assert part.coordinates["dwell"] == 120.0
        assert part.coordinates["room"] == pytest.approx(294.15)
        written = {name: unit(symbol) for name, symbol in WRITTEN.items()}
        assert {name: unit(symbol) for name, symbol in part.written_in.items()} == written


def test_recordings_in_file_have_value_and_unit_as_written(finished):
    with h5py.File(finished.folder / "run.h5") as file:
        (recording,) = file["entry/recordings"].values()
        load, room = recording["setpoints/tester_load"], recording["coordinates/room"]
        assert (load.attrs["written"], load.attrs["written_in"]) == (0.5, "kN")
        assert room.attrs["written"] == pytest.approx(21.0)
        assert room.attrs["written_in"] == "°C"
        assert "written_in" not in recording["setpoints/tester_frequency"].attrs


def test_tables_in_file_have_values_and_units_as_written(finished):
    with h5py.File(finished.folder / "run.h5") as file:
        table = file["entry/measurements/measured"]
        load, dwell = table["setpoints/tester_load"], table["coordinates/dwell"]
        assert (load[()].tolist(), load.attrs["units"]) == ([500.0], "N")
        assert (load.attrs["written"].tolist(), load.attrs["written_in"]) == ([0.5], "kN")
        assert (dwell.attrs["written"].tolist(), dwell.attrs["written_in"]) == ([2.0], "min")
        assert "written_in" not in table["setpoints/tester_frequency"].attrs


def test_show_and_report_use_units_as_written(finished):
    output = call("show", finished.folder.name, "--runs", finished.folder.parent).out
    heads = next(line for line in output.splitlines() if line.startswith("dwell"))
    for head in ("dwell / min", "room / °C", "set tester.load / kN", "set tester.frequency / Hz"):
        assert head in heads
    assert "  tester.load / kN" in heads  # what was set in kN is read back in kN
    report = (finished.folder / "report.html").read_text(encoding="utf-8")
    assert "set tester.load / kN" in report
    assert "room 21 °C" in report


def test_plan_uses_units_as_written(tmp_path):
    (tmp_path / "p.yaml").write_text(PROCEDURE, encoding="utf-8")
    output = call("plan", tmp_path / "p.yaml", "--station", STATION).out
    assert "dwell 2 min, room 21 °C, preload 8 " in output


@pytest.mark.parametrize(
    ("si", "symbol", "text"),
    [(294.15, "°C", "21"), (8 * 4.4482216152605 * 0.0254, "in·lbf", "8"), (0.5, "%", "50")],
)
def test_number_is_formatted_as_written(si, symbol, text):
    assert number_text(si, symbol) == text
    assert written_text(si, "K", symbol) == f"{text} {symbol}"
    assert from_si(si, symbol) == pytest.approx(float(text))


def test_text_and_counts_have_no_unit():
    assert coordinates_text({"phase": "wear", "block": 2}, {}, {"x": "kN"}) == "phase wear, block 2"
    assert number_text("wear", "kN") == "wear"


def test_column_with_several_units_has_them_in_its_cells(finished):
    (row,) = read(finished.folder).measurements
    si_row = type(row)("measured", row.utc, {"tester.load": 1.0}, {}, {})
    empty_row = type(row)("measured", row.utc, {}, {}, {})
    assert written_column([row, row], "tester.load", "N") == ("kN", ["0.5", "0.5"])
    assert written_column([row, empty_row], "tester.load", "N") == ("kN", ["0.5", ""])
    assert written_column([si_row], "tester.load", "N") == ("N", ["1"])
    assert written_column([row, si_row], "tester.load", "N") == ("", ["0.5 kN", "1 N"])
    assert written_column([row], "room", "K") == ("°C", ["21"])


@pytest.mark.parametrize(
    ("values", "cells"),
    [
        ((0.00997, 0.00998, 0.009975), ["9.970", "9.980", "9.975"]),
        ((0.01, None, -0.0205), ["10.0", "", "-20.5"]),
        ((0.001, 0.002), ["1", "2"]),
        ((1.23e-6, 1.0, 0.5), ["0.00123", "1000", "500"]),  # no zeros that were not measured
        ((1.5e-9, 0.0025), ["1.5e-06", "2.5"]),
        ((float("nan"), 0.0025), ["nan", "2.5"]),
    ],
)
def test_measured_values_of_one_unit_have_equal_decimals(values, cells):
    rows = [
        Measurement(
            "m", "", {}, {} if kg is None else {"b.mass": kg}, {}, written_in={"b.mass": "g"}
        )
        for kg in values
    ]
    assert measured_column(rows, "b.mass", "kg") == ("g", cells)
