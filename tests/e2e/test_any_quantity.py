"""A result of a quantity that is not torque, from the procedure to a verified certificate."""

from __future__ import annotations

import csv
import json
import re
import shutil
from math import sqrt

import numpy as np
import pytest

from helpers_any_quantity import PROCEDURE, STATION, written
from helpers_certificate import make_letterhead
from helpers_cli import call
from rigrunner.api.events import Outcome
from rigrunner.registry import load_registry
from rigrunner.run.finish import FinishedRun
from rigrunner.run.stored import analyse_run
from rigrunner_panel.view.result import finished_view

U_READING = 0.002 / sqrt(3)
K_RECTANGLE = 0.95 * sqrt(3)
"""Of one rectangular error: the middle 95 % of it."""


def run(folder, *changes, code=0, procedure=PROCEDURE, station=STATION):
    procedure_file, station = written(folder, *changes, procedure=procedure, station=station)
    called = call("run", procedure_file, "--station", station, "--unattended", "--runs",
                  folder / "runs")  # fmt: skip
    assert called.code == code, called.err
    (found,) = (folder / "runs").iterdir()
    return called, found


@pytest.fixture(scope="module")
def passed(tmp_path_factory):
    return run(tmp_path_factory.mktemp("passed"))


def document(run_folder):
    return json.loads((run_folder / "result.json").read_text(encoding="utf-8"))


def test_results_have_name_unit_place_and_uncertainty(passed):
    *voltages, regulation = document(passed[1])["results"]
    at = [each["coordinates"]["bench.current"] for each in voltages]
    assert at == [{"value": i, "unit": "A"} for i in (0.0, 1.0, 2.0, 5.0)]
    values = [each["estimate"]["value"] for each in voltages]
    assert values == pytest.approx([12.031, 12.022, 12.014, 11.987])
    first = voltages[0]["estimate"]
    assert first["standard_uncertainty"] == pytest.approx(U_READING)
    assert first["expanded_uncertainty_95"] == pytest.approx(K_RECTANGLE * U_READING, rel=1e-4)
    assert regulation["estimate"]["value"] == pytest.approx(44.0)
    assert regulation["estimate"]["unit"] == "mV"
    assert regulation["estimate"]["standard_uncertainty"] == pytest.approx(
        1e3 * sqrt(2) * U_READING
    )
    assert regulation["budget"][0]["contribution"]["unit"] == "mV"
    assert regulation["measurand"] == {"id": "voltage.regulation", "text": "load regulation"}
    assert "measurand" not in voltages[0], "it was told none"


def test_each_limit_is_decided_in_the_unit_of_its_result(passed):
    found = document(passed[1])
    assert found["verdict"]["verdict"] == "pass"
    parts = found["decision"]["parts"]
    places = [f"voltage at bench.current = {i} A" for i in (0, 1, 2, 5)]
    assert [each["of"] for each in parts] == [*places, "regulation"]
    assert parts[-1]["upper_limit"] == {"value": 50.0, "unit": "mV"}
    assert parts[0]["guard_band"]["value"] == pytest.approx(K_RECTANGLE * U_READING, rel=1e-4)
    assert parts[0]["verdict_uncompensated"] is None


def test_show_and_report_have_them(passed):
    shown = call("show", passed[1])
    assert "44.0 ± " in shown.out
    assert "output voltage" in shown.out
    page = (passed[1] / "report.html").read_text(encoding="utf-8")
    assert "load regulation" in page
    assert "Output voltage over bench.current" in page  # the caption of the figure
    assert re.search(r"≤\s50\smV", page)
    assert "Settings of the analysis" in page
    assert "despike" not in page


def test_a_value_out_of_its_limit_fails_and_is_kept(tmp_path):
    _, found = run(tmp_path, ("min: 11.98 V", "min: 12 V"), code=1)
    parts = document(found)["decision"]["parts"]
    assert [each["verdict"] for each in parts] == ["pass", "pass", "pass", "fail", "pass"]
    assert document(found)["decision"]["of"] == "voltage at bench.current = 5 A"
    page = (found / "report.html").read_text(encoding="utf-8")
    assert 'class="missed"' in page


def test_mean_and_worst_are_one_statement_each(tmp_path):
    of_each = "{of: voltage, each: bench.current, min: 11.98 V, max: 12.1 V, source: data sheet}"
    of_mean = "{of: voltage, mean: yes, max: 12.02 V, source: data sheet}"
    of_worst = "{of: voltage, worst: yes, min: 11.9 V, source: data sheet}"
    _, found = run(tmp_path, (of_each, f"{of_mean}\n    - {of_worst}"))
    mean, worst, _ = document(found)["decision"]["parts"]
    assert mean["result"]["value"] == pytest.approx((12.031 + 12.022 + 12.014 + 11.987) / 4)
    assert mean["result"]["standard_uncertainty"] == pytest.approx(U_READING)  # one instrument
    assert worst["of"] == "worst voltage at bench.current = 5 A"
    assert worst["result"]["value"] == pytest.approx(11.987)


OF_RANGE = "readings:\n      of: bench.voltage\n      statistic"
REFUSED = [
    (("of: regulation, max", "of: regulaton, max"), "there is no result", "did you mean 'regul"),
    (("max: 50 mV", "max: 50 mA"), "'50 mA' is a current; regulation is a voltage", "in mV"),
    (("each: bench.current, ", ""), "a result 'voltage' for each bench.current", "worst: yes"),
    (("of: bench.voltage\n      statistic", "of: bench.voltag\n      statistic"),
     "bench.voltag is not measured in any step", "did you mean 'bench.voltage'?"),
    (("per: bench.current", "per: bench.curent"), "'bench.curent' is not set", "bench.current"),
    (("of: bench.voltage\n      statistic", "of: bench.ripple\n      statistic"),
     "there is no instrument for it", "accuracy"),
    ((OF_RANGE, OF_RANGE.replace("readings", "reading")),
     "there is no analysis 'reading'", "did you mean 'readings'?"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "words", "hint"), REFUSED)
def test_check_refuses_what_would_give_no_verdict_with_its_line(tmp_path, change, words, hint):
    procedure, station = written(tmp_path, change)
    called = call("check", procedure, "--station", station)
    assert called.code == 3
    assert words in called.err
    assert hint in called.err
    assert re.search(r"(supply|station)\.yaml:\d+:\d+: error", called.err)


@pytest.mark.parametrize(
    ("volt", "entry", "wrong"),
    [
        ("V", "measures: temperature, accuracy: 2 mK", "got a temperature; bench.voltage is a v"),
        ("dBm", "measures: level, accuracy: {gain: 3 %}",  # 0 dB at 0 dBm, and not 0.13 dB
         "got a level; bench.voltage is a power level"),
    ],
)  # fmt: skip
def test_an_instrument_of_another_quantity_than_its_channel_is_refused(
    tmp_path, volt, entry, wrong
):
    """Its 2 mK would count as 2 mV, also where the result has no limit."""
    instruments = f"  - {{channel: bench.voltage, serial: X, calibration: recorded, {entry}}}\n"
    station = STATION.partition("  - {channel")[0] + instruments
    station = re.sub(r"(voltage: [0-9.]+) V", rf"\1 {volt}", station)
    procedure = PROCEDURE.partition("  - readings:\n      of: bench.voltage\n      statistic")[0]
    files = written(tmp_path, ("unit: V", f"unit: {volt}"), procedure=procedure, station=station)
    called = call("check", files[0], "--station", files[1])
    assert called.code == 3
    assert re.match(r".*station\.yaml:17:\d+: error: instruments\[0\]\.measures: ", called.err)
    assert wrong in called.err


@pytest.fixture(scope="module")
def certified(passed, tmp_path_factory):
    """Certify the run: the letterhead and the folder of the certificate, to be read."""
    folder = tmp_path_factory.mktemp("certified")
    letterhead, out = make_letterhead(folder / "letterhead"), folder / "out"
    issued = call(
        "certify", passed[1], "--letterhead", letterhead, "--authorised-by", "A. Nother",
        "--customer", "C", "--customer-contact", "D", "--item", "Power supply", "--item-id", "1",
        "--item-condition", "new", "--received", "2020-01-01", "--operator", "O",
        "--not-for-certification", "--out", out,
    )  # fmt: skip
    assert issued.code == 0, issued.err
    return letterhead, out


@pytest.mark.thorough
def test_it_is_certified_and_verified(passed, certified):
    letterhead, out = certified
    (content,) = out.glob("*.json")
    certificate = json.loads(content.read_text(encoding="utf-8"))
    names = [each["name"] for each in certificate["named"]]
    assert names == ["voltage"] * 4 + ["regulation"]
    assert certificate["named"][-1]["found"]["printed"] == "44.0"
    units = {each["of"]: each["unit"] for each in certificate["conformity"]["statements"]}
    assert units["regulation"] == "mV"
    assert units["voltage at bench.current = 0 A"] == "V"
    verified = call("verify", content, "--letterhead", letterhead, "--runs", passed[1].parent)
    assert verified.code == 0, verified.out + verified.err
    page = next(out.glob("*.html")).read_text(encoding="utf-8")
    assert "load regulation" in page
    assert "cycle" not in page.lower()


@pytest.mark.thorough
def test_a_certificate_whose_number_was_changed_does_not_verify(passed, certified, tmp_path):
    letterhead, out = certified
    shutil.copytree(out, tmp_path / "out")
    (content,) = (tmp_path / "out").glob("*.json")
    text = content.read_text(encoding="utf-8")
    assert '"printed": "44.0"' in text
    content.write_text(text.replace('"printed": "44.0"', '"printed": "43.0"'), encoding="utf-8")
    verified = call("verify", content, "--letterhead", letterhead, "--runs", passed[1].parent)
    assert verified.code == 1
    assert "named" in verified.out + verified.err


def test_a_run_without_an_analysis_has_a_report_of_what_was_measured(tmp_path):
    recorded = PROCEDURE[: PROCEDURE.index("analysis:")]
    _, found = run(tmp_path, procedure=recorded)
    assert not (found / "report.html").exists()
    called = call("report", found)
    assert called.code == 0, called.err
    page = (found / "report.html").read_text(encoding="utf-8")
    assert "Rows of measured values" in page
    assert "12.031" in page
    assert "Table measured, over bench.current." in page


BLOCKS = """\
rigrunner: procedure/2
id: PSU-BLOCKS
revision: "A"
title: Voltage before and after a rest
uses: {bench: supply_bench}
main:
  - set: {bench.current: 1 A}
  - group:
      label: {phase: cold}
      steps: [{measure: {channels: [bench.voltage]}}]
  - set: {bench.current: 5 A}
  - repeat:
      times: 2
      as: block
      label: {phase: warm}
      steps: [{measure: {channels: [bench.voltage]}}]
analysis:
  - readings: {of: bench.voltage, per: [phase], result: {name: voltage, unit: V}}
  - readings:
      of: bench.voltage
      where: {phase: warm, block: 2}
      result: {name: last, unit: V}
acceptance:
  limits:
    - {of: voltage, where: {phase: warm}, min: 11.9 V, source: data sheet}
"""


def test_results_are_told_apart_and_limited_by_labels_and_counters(tmp_path):
    _, found = run(tmp_path, procedure=BLOCKS)
    cold, warm, last = document(found)["results"]
    assert [cold["coordinates"], warm["coordinates"]] == [{"phase": "cold"}, {"phase": "warm"}]
    assert [cold["readings"], warm["readings"], last["readings"]] == [1, 2, 1]
    assert warm["estimate"]["value"] == pytest.approx(11.987)
    (part,) = document(found)["decision"]["parts"]
    assert part["of"] == "voltage at phase = warm"
    assert document(found)["verdict"]["verdict"] == "pass"


def test_an_archive_finds_them_by_name(passed, tmp_path):
    database = tmp_path / "archive.db"
    indexed = call("archive", "index", passed[1].parent, "--database", database)
    assert indexed.code == 0, indexed.err
    out = tmp_path / "results.csv"
    options = ("--database", database, "--result", "voltage", "--where", "current=5 A")
    exported = call("archive", "export", "results", out, *options)
    assert exported.code == 0, exported.err
    (row,) = csv.DictReader(out.read_text(encoding="utf-8").splitlines())
    assert (row["place"], row["value"], row["unit"]) == ("bench.current = 5 A", "11.987", "V")
    searched = call("archive", "search", *options)
    assert re.search(r"voltage +bench\.current = 5 A +11\.987\d ± 0\.00\d+ V +pass", searched.out)
    assert searched.err == "1 result\n"
    twice = call("archive", "search", *options, "--where", "current=2 A")
    assert (twice.code, "'--where current' is given twice" in twice.err) == (2, True)


def test_it_can_be_decided_again_by_another_limit(tmp_path):
    _, found = run(tmp_path)
    limits = tmp_path / "limits.yaml"
    text = "rigrunner: acceptance/1\nacceptance:\n  limits:\n    - {of: %s, max: %s, source: me}\n"
    limits.write_text(text % ("regulation", "40 mV"), encoding="utf-8")
    who = ("--by", "A. Nother", "--reason", "a tighter data sheet")
    again = call("decide", found, "--acceptance", limits, *who)
    assert again.code == 1, again.err
    assert "utside the limit ≤ 40 mV by 4.0 mV" in again.out
    for name, most, words in (
        ("ripple", "40 mV", "has no result 'ripple'"),
        ("regulation", "40 mA", "is a current; regulation is a voltage"),
    ):
        limits.write_text(text % (name, most), encoding="utf-8")
        refused = call("decide", found, "--acceptance", limits, *who)
        assert refused.code != 0
        assert words in refused.err
    other_rule = call("decide", found, "--rule", "guard_band_u", *who)
    assert other_rule.code == 1


CHAMBER = """\
rigrunner: station/1
id: chamber
title: Two thermometers
devices:
  bath:
    type: bath
    plugin: tabulated
    settings:
      title: a bath, written down
      set_points: [level]
      rows: [{level: 1 m, indicated: 20.4 °C, applied: 20 °C}]
instruments:
  - {channel: bath.indicated, measures: temperature, serial: T-1, calibration: recorded,
     accuracy: 0.05 K}
  - {channel: bath.applied, measures: temperature, serial: T-2, calibration: recorded,
     accuracy: 0.05 K}
"""
DEVIATION = """\
rigrunner: procedure/2
id: BATH
revision: "A"
title: Deviation of a thermometer
uses: {bath: bath}
main: [{set: {bath.level: 1 m}}, {measure: {channels: [bath.indicated, bath.applied]}}]
analysis:
  - readings: {of: bath.indicated, minus: bath.applied, result: {name: deviation, unit: K}}
acceptance: {limits: [{of: deviation, max: 0.3 K, source: me}]}
"""


def test_a_limit_in_celsius_is_no_limit_of_a_difference(tmp_path):
    """0.3 °C was 273.45 K, within which any deviation is."""
    paths = written(tmp_path, procedure=DEVIATION, station=CHAMBER)
    ran = call("run", paths[0], "--station", paths[1], "--unattended", "--runs", tmp_path / "runs")
    assert ran.code == 1, ran.err
    (folder,) = (tmp_path / "runs").iterdir()
    celsius = ("max: 0.3 K", "max: 0.3 °C")
    wrong = written(tmp_path / "wrong", celsius, procedure=DEVIATION, station=CHAMBER)
    limits = tmp_path / "limits.yaml"
    acceptance = DEVIATION.partition("acceptance:")[2].replace(*celsius)
    limits.write_text(f"rigrunner: acceptance/1\nacceptance:{acceptance}", encoding="utf-8")
    who = ("--by", "A. Nother", "--reason", "in another unit")
    for refused in (
        call("check", wrong[0], "--station", wrong[1]),
        call("decide", folder, "--acceptance", limits, *who),
    ):
        assert refused.code != 0
        message = "'0.3 °C' is a temperature, and deviation, in K, may be a difference"
        assert message in refused.err
        assert "write '0.3 K' for a difference, else '273.45 K'" in refused.err


def test_the_limit_with_least_to_spare_decides_among_those_that_are_sure(passed):
    assert document(passed[1])["decision"]["of"] == "regulation"


def test_the_panel_shows_the_result_on_which_the_verdict_rests(passed):
    result = analyse_run(passed[1], load_registry())
    ended = FinishedRun(
        folder=passed[1], outcome=Outcome.COMPLETED, reason="", error=None, result=result
    )
    assert finished_view(ended).result == "load regulation: 44.0 ± 3.1 mV"  # 4 mV (1 - √0.05)


def test_two_runs_are_compared_result_by_result(passed, tmp_path):
    station = STATION.replace("11.987 V", "11.986 V").replace("12.022 V", "12.042 V")
    procedure, bench = written(tmp_path, station=station)
    call("run", procedure, "--station", bench, "--unattended", "--runs", tmp_path / "runs")
    (other,) = (tmp_path / "runs").iterdir()
    told = call("compare", passed[1], other).out
    # 1 mV and 20 mV apart, each known to 1.9 mV: E_n = 0.37 and 7.4
    assert "within their combined U of 0.0027 V (E_n = 0.37)" in told
    assert "voltage at bench.current = 1 A: 12.0220 and 12.0420 V: +0.0200 V, beyond" in told


def test_a_result_whose_instrument_is_not_registered_says_that_u_is_unknown(tmp_path):
    only = PROCEDURE[: PROCEDURE.index("  - readings:\n      of: bench.voltage\n      statistic")]
    _, found = run(tmp_path, ("of: bench.voltage\n", "of: bench.ripple\n"), procedure=only)
    assert "0.003, U unknown" in call("show", found).out
    assert '<th scope="col">Limit</th>' not in (found / "report.html").read_text("utf-8")


CURVE = """\
  - curve:
      of: bench.voltage
      over: bench.current
      fit: {polynomial: {degree: 1}}
      results:
        slope: {name: resistance, symbol: R, text: source resistance, unit: mΩ}
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("polynomial:", "polynomal:", "there is no fit 'polynomal'"),
        ("degree: 1", "degree: 11", "analysis[2].curve.fit.polynomial.degree"),
        ("degree: 1", "grade: 1", "analysis[2].curve.fit.polynomial.grade"),
        (
            "over: bench.current",
            "over: bench.curent",
            "bench.curent is not measured or set in any step",
        ),
        ("unit: mΩ", "unit: V", "slope.unit: got 'V', a voltage; it is a resistance"),
        ("slope: {", "slope: {at: 1 V, ", "slope.at: got '1 V', a voltage; expected a current"),
        (
            "slope: {name: resistance",
            "hysteresis: {between: {way: [up, down]}, name: resistance",
            "way is not measured or set in any step",
        ),
    ],
)
def test_a_mistake_in_a_curve_is_found_before_anything_moves(tmp_path, old, new, words):
    wrong = CURVE.replace(old, new)
    assert wrong != CURVE
    files = written(tmp_path, ("acceptance:\n", f"{wrong}acceptance:\n"))
    called = call("check", files[0], "--station", files[1])
    assert called.code == 3
    assert words in called.err
    assert re.search(r"supply\.yaml:\d+:\d+: error: ", called.err)


def test_a_curve_over_a_set_point_is_a_result_with_its_fit_on_record(tmp_path):
    files = written(tmp_path, ("acceptance:\n", f"{CURVE}acceptance:\n"))
    called = call("run", files[0], "--station", files[1], "--unattended", "--runs", tmp_path / "r")
    assert called.code == 0, called.err
    (run,) = (tmp_path / "r").iterdir()
    document = json.loads((run / "result.json").read_text(encoding="utf-8"))
    (found,) = [each for each in document["results"] if each["name"] == "resistance"]
    # least squares by hand: mean current 2, sum of squares 14, sum of products -0.1215 V·A
    amperes, volts = (0, 1, 2, 5), (12.031, 12.022, 12.014, 11.987)
    products = sum((i - 2) * u for i, u in zip(amperes, volts, strict=True))
    assert found["estimate"]["value"] == pytest.approx(1000 * products / 14, rel=1e-9)
    assert document["revisions"]["fit polynomial"] == 1
    assert call("verify", run).code == 0


def test_the_figure_of_a_curve_is_in_the_report_and_as_data_in_the_result(tmp_path):
    files = written(tmp_path, ("acceptance:\n", f"{CURVE}acceptance:\n"))
    called = call("run", files[0], "--station", files[1], "--unattended", "--runs", tmp_path / "r")
    assert called.code == 0, called.err
    (run,) = (tmp_path / "r").iterdir()
    curve, residuals = json.loads((run / "result.json").read_text(encoding="utf-8"))["figures"]
    for figure in (curve, residuals):
        assert [point["x"] for point in figure["series"][1]["points"]] == [0, 1, 2, 5]
    page = (run / "report.html").read_text(encoding="utf-8")
    assert "bench.voltage over bench.current: points, and the curve with its" in page
    assert "Residuals of bench.voltage over bench.current" in page


def test_a_slope_in_volts_per_ampere_is_no_statistic_of_readings_and_check_says_what_is(tmp_path):
    file, station = written(
        tmp_path, ("statistic: range", "statistic: slope"), ("unit: mV", "unit: V/A")
    )
    called = call("check", file, "--station", station)
    assert called.code == 3
    assert "a slope over a channel or set-point is a result of the analysis 'curve'" in called.err


LEAK = """\
rigrunner: station/1
id: leak
title: A chamber with a leak
devices:
  chamber:
    type: chamber
    plugin: tabulated
    settings:
      title: a chamber, written down
      set_points: [reading]
      rows:
        - {reading: 1 1, pressure: 3.000 bar, temperature: 20.0 °C}
        - {reading: 2 1, pressure: 3.002 bar, temperature: 20.5 °C}
        - {reading: 3 1, pressure: 3.005 bar, temperature: 21.1 °C}
        - {reading: 4 1, pressure: 3.006 bar, temperature: 21.4 °C}
"""
DECAY = """\
rigrunner: procedure/2
id: LEAK
revision: "A"
title: Leak rate by pressure decay, at 20 °C
uses: {chamber: chamber}
main:
  - sweep:
      set: chamber.reading
      over: [1 1, 2 1, 3 1, 4 1]
      steps:
        - wait: {time: 5 min}
        - measure: {channels: [chamber.pressure, chamber.temperature]}
analysis:
  - equation:
      result: {name: p_20, unit: Pa}
      model: p_20 = p * (t_20 - t_0) / (t - t_0)
      inputs: {p: chamber.pressure, t: chamber.temperature}
      constants: {t_20: 20 °C, t_0: -273.15 °C}
      per: elapsed
  - curve:
      of: p_20
      over: elapsed
      fit: {polynomial: {degree: 1}}
      results: {slope: {name: decay, unit: Pa/s}}
  - equation:
      result: {name: leak, unit: mbar·L/s}
      model: leak = -V * dp
      inputs: {dp: decay}
      constants: {V: 50 L}
"""


def test_a_leak_rate_by_a_fit_over_time_of_a_pressure_that_an_equation_corrects(tmp_path):
    _, found = run(tmp_path, procedure=DECAY, station=LEAK)
    *corrected, decay, leak = document(found)["results"]
    times = [each["coordinates"]["elapsed"]["value"] for each in corrected]
    assert np.diff(times) == pytest.approx(300, abs=1)
    kelvin = np.array([20.0, 20.5, 21.1, 21.4]) + 273.15
    pressures = np.array([3.000, 3.002, 3.005, 3.006]) * 1e5 * 293.15 / kelvin
    slope = np.polyfit(times, pressures, 1)[0]
    assert decay["estimate"]["value"] == pytest.approx(slope, rel=1e-6)
    assert leak["estimate"]["value"] == pytest.approx(-slope * 0.05 * 10, rel=1e-6)
