"""A fitted curve in a report: its formula as mathematics, in the units of the procedure."""

from __future__ import annotations

import json

import pytest

from helpers_any_quantity import STATION, written
from helpers_certificate import make_letterhead
from helpers_cli import call
from helpers_figures import drawn

pytestmark = pytest.mark.usefixtures("without_pdf")

PROCEDURE = """\
rigrunner: procedure/2
id: PSU-R
revision: "A"
title: Internal resistance of a supply
inputs: {specimen: {ask: Serial number, unattended: PSU-1}}
uses: {bench: supply_bench}
main:
  - sweep:
      set: bench.current
      over: [0 mA, 1000 mA, 2000 mA, 5000 mA]
      steps: [{measure: {channels: [bench.voltage]}}]
analysis:
  - curve:
      of: bench.voltage
      over: bench.current
      fit: {polynomial: {degree: 1}}
      results: {slope: {name: resistance, unit: mΩ}}
acceptance: {limits: [{of: resistance, min: -20 mΩ, source: sheet}]}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("curve")
    procedure, station = written(folder, procedure=PROCEDURE, station=STATION)
    called = call("run", procedure, "--station", station, "--unattended", "--runs", folder / "r")
    assert called.code == 0, called.err
    (run_folder,) = (folder / "r").iterdir()
    return run_folder


def test_report_has_the_formula_and_its_parameters(run):
    page = (run / "report.html").read_text(encoding="utf-8")
    assert page.count('alttext="voltage = c0 + c1*current"') == 2
    # by least squares of 12.031, 12.022, 12.014 and 11.987 V over 0, 1, 2 and 5 A
    assert "<mtext>12.03107 V</mtext>" in page  # numpy: 12.031071, u 0.00031
    assert "<mtext>(\N{MINUS SIGN}8.79 \N{MULTIPLICATION SIGN} 10⁻⁶ V/mA)</mtext>" in page
    assert "<caption>Parameters of the fit, with u from the scatter about the curve" in page
    (figure, *_) = json.loads((run / "result.json").read_text(encoding="utf-8"))["figures"]
    assert figure["x"]["unit"] == "mA"
    points = figure["series"][1]["points"]
    assert [point["x"] for point in points] == pytest.approx([0, 1000, 2000, 5000])


def test_certificate_has_the_results_but_no_curve(run, tmp_path):
    with drawn():
        called = call(
            "certify", run, "--letterhead", make_letterhead(tmp_path / "letterhead"),
            "--authorised-by", "A. Nother", "--customer", "C", "--customer-contact", "D",
            "--item", "I", "--item-id", "1", "--item-condition", "new", "--received",
            "2020-01-01", "--operator", "O", "--not-for-certification", "--out", tmp_path / "out",
        )  # fmt: skip
    assert called.code == 0, called.err
    (path,) = (tmp_path / "out").glob("*.json")
    assert json.loads(path.read_text(encoding="utf-8")).get("models", []) == []
