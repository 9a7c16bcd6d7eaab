"""The shipped procedure of a platinum sensor, on a chamber and an ohmmeter over SCPI."""

from __future__ import annotations

import csv
import json
import re
from math import sqrt

import pytest

from helpers_cli import call
from rigrunner.api.errors import UsageError
from rigrunner.run.locate import find_procedure
from rigrunner_fleet.notebook import analyse, open_run
from rigrunner_plugins.loopback.chamber import DEVIATION_K, platinum, running_chamber

pytestmark = pytest.mark.in_real_time

TEMPERATURES_C = (-20.0, 0.0, 50.0, 100.0)
PROCEDURE = find_procedure("resistance_over_temperature")
NOMINAL_OHM = {-20.0: 92.16, 0.0: 100.00, 50.0: 119.40, 100.0: 138.51}
"""As printed in IEC 60751:2022, table 1."""


@pytest.fixture(scope="module")
def tested(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rtd")
    with running_chamber() as bench:
        (folder / "station.yaml").write_text(bench.station(), encoding="utf-8")
        called = call(
            "run", PROCEDURE, "--station", folder / "station.yaml", "--unattended", "--runs",
            folder / "runs",
        )  # fmt: skip
    assert called.code == 0, called.err
    (run_folder,) = (folder / "runs").iterdir()
    return run_folder, json.loads((run_folder / "result.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("celsius", TEMPERATURES_C)
def test_loopback_sensor_follows_the_standard(celsius):
    assert platinum(celsius) == pytest.approx(NOMINAL_OHM[celsius], abs=0.005)


def test_limits_are_those_of_class_b(tested):
    """The tolerance of the standard, ±(0.30 + 0.005 |t|) °C, at each point."""
    parts = {part["of"]: part for part in tested[1]["decision"]["parts"]}
    for t in TEMPERATURES_C:
        part = parts[f"deviation at chamber.temperature = {t:g} °C"]
        assert part["lower_limit"] == {"value": pytest.approx(-0.30 - 0.005 * abs(t)), "unit": "K"}
        assert part["upper_limit"] == {"value": pytest.approx(0.30 + 0.005 * abs(t)), "unit": "K"}


def test_deviations_are_those_of_the_sensor(tested):
    deviations = [each for each in tested[1]["results"] if each["name"] == "deviation"]
    assert len(deviations) == len(TEMPERATURES_C)
    for deviation in deviations:
        assert deviation["estimate"]["unit"] == "K"
        error = deviation["estimate"]["value"] - DEVIATION_K
        assert abs(error) < deviation["estimate"]["expanded_uncertainty_95"] < 0.1


def distance_to_limit(part):
    value, u = (part["result"][key] for key in ("value", "standard_uncertainty"))
    low, high = (part[key]["value"] for key in ("lower_limit", "upper_limit"))
    return min(value - low, high - value) / u


def test_overall_verdict_names_the_worst_point(tested):
    """All conform almost certainly: the worst is nearest to its limit in standard uncertainties."""
    decision = tested[1]["decision"]
    worst, *parts = decision["parts"]
    assert len(parts) == len(TEMPERATURES_C)
    assert {part["probability_of_conformity"] > 0.999 for part in parts} == {True}
    least = min(parts, key=distance_to_limit)
    assert worst["of"] == f"worst {least['of']}" == decision["of"]
    assert worst["coordinates"] == least["coordinates"]


def test_each_resistance_has_its_uncertainty(tested):
    resistances = [each for each in tested[1]["results"] if each["name"] == "resistance"]
    at = [resistance["coordinates"]["chamber.temperature"] for resistance in resistances]
    assert at == [{"value": t, "unit": "°C"} for t in TEMPERATURES_C]
    for resistance, t in zip(resistances, TEMPERATURES_C, strict=True):
        estimate = resistance["estimate"]
        assert estimate["unit"] == "Ω"
        assert estimate["value"] == pytest.approx(platinum(t + DEVIATION_K), abs=0.02)
        assert estimate["standard_uncertainty"] > 0.010 / sqrt(3)
        assert resistance["readings"] == 5
        assert [line["name"] for line in resistance["budget"]] == [
            "scatter of the readings", "reading of meter.resistance",
        ]  # fmt: skip


def test_sensor_passes_and_the_report_shows_each_limit(tested):
    folder, document = tested
    assert document["verdict"]["verdict"] == "pass"
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "resistance of the sensor" in page
    assert len(re.findall(r"-0\.55\sK to 0\.55\sK", page)) >= 1
    assert call("verify", folder).code == 0


MAXIMUM = """\
rigrunner: analysis/1
named:
  - readings:
      of: meter.resistance
      statistic: maximum
      per: chamber.temperature
      result: {name: resistance, symbol: R, text: resistance of the sensor, unit: Ω}
"""


@pytest.mark.thorough
def test_archive_finds_a_result_by_its_temperature(tested, tmp_path):
    database = ("--database", tmp_path / "archive.sqlite")
    assert call("archive", "index", tested[0].parent, *database).code == 0
    criteria = ("--result", "deviation=0.05..0.15 K", "--where", "temperature=100 °C")
    found = call("archive", "search", *criteria, *database)
    assert re.search(
        r"deviation +chamber\.temperature = 100 °C +0\.\d+ ± 0\.\d+ K +pass", found.out
    )
    assert found.err == "1 result\n"


def test_notebook_has_the_results(tested):
    rows = open_run(tested[0]).results
    assert rows.column("place")[:4] == [f"chamber.temperature = {t:g} °C" for t in TEMPERATURES_C]
    stated = [result["estimate"]["value"] for result in tested[1]["results"]]
    assert rows.column("value") == stated
    assert analyse(tested[0]).results == rows


@pytest.mark.usefixtures("drawn_figures")
def test_notebook_draws_the_figures_of_the_report(tested):
    (values,) = open_run(tested[0]).plot_results("deviation").figure.axes
    stated = [
        each["estimate"]["value"] for each in tested[1]["results"] if each["name"] == "deviation"
    ]
    assert list(values.lines[0].get_ydata()) == pytest.approx(stated)
    assert values.get_ylabel() == "d / K"
    with pytest.raises(UsageError, match="no result 'resistanse'"):
        open_run(tested[0]).plot_results("resistanse")


@pytest.mark.thorough
def test_golden_runs_detect_another_statistic(tested, tmp_path):
    changed, golden = tmp_path / "analysis.yaml", tmp_path / "golden"
    changed.write_text(MAXIMUM, encoding="utf-8")
    one = ("--jobs", "1")
    assert call("golden", "record", tested[0].parent, "--out", golden, *one).code == 0
    assert "No change in 1 golden run" in call("golden", "check", golden, *one).out
    page = tmp_path / "golden.html"
    checked = call("golden", "check", golden, *one, "--analysis", changed, "--json", "--html", page)
    assert checked.code == 1, checked.err
    (run,) = json.loads(checked.out)["runs"]
    moves = {move["figure"]: move for move in run["moves"]}
    at_100 = moves["resistance at chamber.temperature = 100 °C"]
    values = [
        row.values["meter.resistance"] for row in open_run(tested[0]).stored.measurements[-5:]
    ]
    assert at_100["now"] == pytest.approx(max(values))
    assert at_100["reference"] == pytest.approx(sum(values) / 5)
    assert moves["air at chamber.temperature = 0 °C"]["now"] is None, "it is not asked for"
    html = page.read_text(encoding="utf-8")
    assert "How many results moved by how much" in html
    assert "Set-point" not in html, "there is none of a torque"


@pytest.mark.thorough
def test_reanalysis_has_a_line_for_each_result(tested, tmp_path):
    changed, out = tmp_path / "analysis.yaml", tmp_path / "again"
    changed.write_text(MAXIMUM, encoding="utf-8")
    done = call("reanalyse", tested[0], "--out", out, "--jobs", "1", "--analysis", changed)
    assert done.code == 0, done.err
    rows = list(csv.DictReader((out / "results.csv").read_text(encoding="utf-8").splitlines()))
    by_name = {row["result"]: row for row in rows}
    assert len(by_name) == 12
    first = by_name["resistance at chamber.temperature = -20 °C"]
    assert float(first["value"]) > float(first["value_before"])
    assert (first["unit"], by_name["air at chamber.temperature = 0 °C"]["value"]) == ("Ω", "")
