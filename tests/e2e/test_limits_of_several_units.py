"""Limits of a torque, an angle and a torque in another unit in one procedure, on every document."""

from __future__ import annotations

import json

import pytest

from helpers_certificate import issue, make_letterhead
from helpers_cli import call
from helpers_workflow import quick_procedure, run
from rigrunner.run.locate import find_station
from unit.rigrunner_reports.helpers_html import read_html

pytestmark = pytest.mark.usefixtures("without_pdf")

ENCODER = """\
  - {channel: tester.angle, measures: angle, serial: ENC-1, calibration: recorded,
     accuracy: 0.01 deg}
"""
READINGS = """\
      primary: template_inverse
  - readings:
      {of: tester.angle, statistic: range, per: tester.frequency,
       result: {name: stroke, symbol: s, text: stroke of the swing, unit: deg}}
  - readings: {of: tester.torque, statistic: rms, result: {name: effective, unit: mN·m}}
"""
LIMITS = """\
    - {of: torque, each: frequency, max: 1 N·m, source: drawing 2,
       measurand: {nature: load_induced, condition: at_reversal}}
    - {of: stroke, each: tester.frequency, worst: yes, min: 5 deg, max: 5.2 deg, source: drawing 3}
    - {of: effective, max: 2000 mN·m, source: drawing 4}
  rule: guard_band_u
"""
FREQUENCIES = ("8 Hz", "15 Hz", "20 Hz", "25 Hz", "35 Hz")
WORST = "the worst of stroke"


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("units")
    station = folder / "station.yaml"
    text = find_station("simulated").read_text(encoding="utf-8")
    station.write_text(f"{text.rstrip()}\n{ENCODER}", encoding="utf-8")
    run(quick_procedure(folder, "no_load_inertia_sweep"), folder / "runs", station=station)
    procedure = quick_procedure(
        folder,
        "starting_torque_1000n",
        ("      primary: template_inverse\n", READINGS),
        ("  rule: guard_band_u\n", LIMITS),
    )
    return run(procedure, folder / "runs", station=station)


@pytest.fixture(scope="module")
def issued(done, tmp_path_factory):
    folder = tmp_path_factory.mktemp("office")
    letterhead = make_letterhead(folder / "letterhead")
    return letterhead, issue(done.folder, letterhead, folder / "out")


def test_each_limit_is_decided_in_its_unit(done):
    """The effective torque of 2.5 N·m exceeds 2000 mN·m; all other results are within limits."""
    parts = done.result.decision.parts
    assert [(part.named, part.limits.unit) for part in parts] == [
        *[("torque", "N·m")] * (1 + len(FREQUENCIES)),
        *[("stroke", "deg")] * (1 + len(FREQUENCIES)),
        ("effective", "mN·m"),
    ]
    assert [str(part.verdict) for part in parts] == ["pass"] * (len(parts) - 1) + ["fail"]
    assert done.result.decision.reason.startswith("effective: Outside the limit ≤ 2000 mN·m")
    document = json.loads((done.folder / "result.json").read_text(encoding="utf-8"))
    stroke = document["decision"]["parts"][-2]
    assert stroke["coordinates"] == {"tester.frequency": {"value": 35.0, "unit": "Hz"}}


def test_show_and_report_name_each_limited_result(done):
    shown = call("show", done.folder).out
    page = read_html((done.folder / "report.html").read_bytes()).words
    for words in (
        "torque, mean",
        "torque, 8 Hz",
        "stroke at tester.frequency = 35 Hz",
        "effective",
    ):
        assert words in shown
        assert words in page
    assert "mN·m against ≤ 2000 mN·m" in shown


@pytest.mark.thorough
def test_certificate_has_each_limit_with_its_result_and_unit(issued):
    _, document = issued
    statements = {
        statement.of: statement for statement in document.certificate.conformity.statements
    }
    first = document.certificate.conformity.statements[0]
    assert (first.of, first.unit, first.upper) == ("effective", "mN·m", 2000.0)
    assert first.printed_result.endswith(" mN·m")
    stroke = statements["stroke at tester.frequency = 35 Hz"]
    assert (stroke.lower, stroke.upper, stroke.unit) == (5.0, 5.2, "deg")
    assert stroke.coordinates["tester.frequency"].printed == "35 Hz"
    assert statements["35 Hz"].named == "torque"
    assert statements["35 Hz"].coordinates["frequency"].value == 35.0


def test_certificate_page_shows_limits_and_deciding_result(issued):
    _, document = issued
    (path,) = (file for file in document.files if file.suffix == ".html")
    words = read_html(path.read_bytes()).words
    for frequency in FREQUENCIES:
        assert f"torque frequency = {frequency}" in words
        assert f"stroke tester.frequency = {frequency}" in words
    assert WORST in words
    assert "Decided by effective: 25" in words


@pytest.mark.thorough
def test_certificate_verifies(done, issued):
    letterhead, document = issued
    (path,) = (file for file in document.files if file.suffix == ".json")
    called = call("verify", path, "--letterhead", letterhead, "--runs", done.folder.parent)
    assert (called.code, called.out.splitlines()[0]) == (0, "MATCH"), called.out
