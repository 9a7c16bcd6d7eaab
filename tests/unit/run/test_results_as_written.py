"""Coordinates of results, limits and measured columns are shown in the units as written."""

from __future__ import annotations

import json

import h5py
import pytest

from helpers_cli import call
from rigrunner.api.coordinates import CoordinateValue
from rigrunner.runfile import read
from rigrunner_fleet.notebook import open_run

STATION = """\
rigrunner: station/1
id: bench
title: A table in customary units
devices:
  bench:
    type: table
    plugin: tabulated
    settings:
      title: written down
      set_points: [temperature]
      rows:
        - {temperature: 70 °F, probe: 70.5 °F, drag: 8 in·lbf}
        - {temperature: 21 °C, probe: 70.2 °F, drag: 8.2 in·lbf}
        - {temperature: 300 K, probe: 80.6 °F, drag: 8.4 in·lbf}
instruments:
  - {channel: bench.drag, measures: torque, serial: Q-1, calibration: recorded,
     full_scale: 20 in·lbf, accuracy: 0.5 % FS}
"""
PROCEDURE = """\
rigrunner: procedure/2
id: CUSTOMARY
revision: "A"
title: In the units that a person wrote
uses: {bench: table}
main:
  - sweep:
      set: bench.temperature
      over: [70 °F, 21 °C, 300 K]
      steps:
        - measure: {channels: [bench.probe, bench.drag], limits: {bench.drag: {max: 9 in·lbf}}}
analysis:
  - readings:
      of: bench.drag
      per: bench.temperature
      result: {name: drag, text: drag torque, unit: in·lbf}
acceptance:
  limits:
    - {of: drag, each: bench.temperature, max: 9 in·lbf, source: drawing}
    - {of: drag, where: {bench.temperature: 294.15 K}, max: 8.5 in·lbf, source: drawing}
"""
PLACES = ["70 °F", "21 °C", "300 K"]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("customary")
    (folder / "p.yaml").write_text(PROCEDURE, encoding="utf-8")
    (folder / "s.yaml").write_text(STATION, encoding="utf-8")
    result = call(
        "run", folder / "p.yaml", "--station", folder / "s.yaml", "--runs", folder / "runs"
    )
    assert result.code == 0, result.err
    return next((folder / "runs").glob("*_CUSTOMARY*"))


def test_coordinates_of_results_are_as_written(run):
    document = json.loads((run / "result.json").read_text(encoding="utf-8"))
    coordinates = [result["coordinates"]["bench.temperature"] for result in document["results"]]
    assert coordinates == [
        {"value": 70.0, "unit": "°F"},
        {"value": 21.0, "unit": "°C"},
        {"value": 300.0, "unit": "K"},
    ]


def test_report_and_show_have_coordinates_and_columns_as_written(run):
    output = call("show", run.name, "--runs", run.parent).out
    report = (run / "report.html").read_text(encoding="utf-8")
    assert "bench.probe / °F  bench.drag / in·lbf" in output
    for text in ("bench.probe / °F", "bench.drag / in·lbf"):
        assert text in report
    rows = [line.split()[:4] for line in output.splitlines() if line.endswith("pass")]
    measured = [row for row in rows if row[:1] in (["70"], ["21"], ["300"])]
    assert measured == [
        ["70", "°F", "70.5", "8.0"],
        ["21", "°C", "70.2", "8.2"],
        ["300", "K", "80.6", "8.4"],
    ]
    for place in PLACES:
        assert f"drag at bench.temperature = {place}" in output
    limit_line = "drag at bench.temperature = 21 °C pass: 8.200 ± 0.095 in·lbf against ≤ 8.5 in·lbf"
    assert limit_line in " ".join(output.split())


def test_file_has_values_as_written_and_in_si(run):
    with h5py.File(run / "run.h5") as file:
        table = file["entry/measurements/measured/values"]
        probe, drag = table["bench_probe"], table["bench_drag"]
        assert probe.attrs["units"] == "K"
        assert probe[0] == pytest.approx((70.5 + 459.67) * 5 / 9)
        assert (probe.attrs["written_in"], drag.attrs["written_in"]) == ("°F", "in·lbf")
        assert probe.attrs["written"].tolist() == pytest.approx([70.5, 70.2, 80.6])
        assert drag.attrs["written"].tolist() == pytest.approx([8.0, 8.2, 8.4])


def test_notebook_has_si_values_and_display_units(run):
    frame = open_run(run).measurements("measured")
    assert frame["bench.drag"][0] == pytest.approx(8 * 4.4482216152605 * 0.0254)
    assert frame.attrs["units"]["bench.probe"] == "K"
    assert frame.attrs["shown_in"]["bench.probe"] == "°F"


def test_coordinates_in_two_units_are_the_same_place():
    warm, same = CoordinateValue(70.0, "°F"), CoordinateValue((70 + 459.67) * 5 / 9, "K")
    assert warm != same
    assert warm.usual == same.usual == CoordinateValue(21.11111111, "°C")
    assert CoordinateValue(5.0, "mA").usual == CoordinateValue(0.005, "A").usual
    assert CoordinateValue("wear").usual == CoordinateValue("wear")
    assert str(CoordinateValue(10.0, "°C").in_unit("°F")) == "50 °F"


def test_default_display_is_si_with_temperatures_in_celsius():
    assert str(CoordinateValue.of_si(294.15, "K")) == "21 °C"
    assert str(CoordinateValue.of_si(294.15, "K", "K")) == "294.15 K"
    assert str(CoordinateValue.of_si(0.5, "A")) == "0.5 A"


def test_stored_rows_have_their_units(run):
    for row in read(run).measurements:
        assert row.written_in["bench.drag"] == "in·lbf"
