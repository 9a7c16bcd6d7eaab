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
    (found,) = (folder / "runs").iterdir()
    return found, json.loads((found / "result.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("celsius", TEMPERATURES_C)
def test_the_loopback_sensor_is_the_standard_s(celsius):
    assert platinum(celsius) == pytest.approx(NOMINAL_OHM[celsius], abs=0.005)


def test_the_limits_are_class_b(tested):
    """Tolerance of the standard, ±(0.30 + 0.005 |t|) °C, at each point."""
    parts = {each["of"]: each for each in tested[1]["decision"]["parts"]}
    for t in TEMPERATURES_C:
        part = parts[f"deviation at chamber.temperature = {t:g} °C"]
        assert part["lower_limit"] == {"value": pytest.approx(-0.30 - 0.005 * abs(t)), "unit": "K"}
        assert part["upper_limit"] == {"value": pytest.approx(0.30 + 0.005 * abs(t)), "unit": "K"}


def test_each_deviation_is_the_one_that_the_sensor_has(tested):
    found = [each for each in tested[1]["results"] if each["name"] == "deviation"]
    assert len(found) == len(TEMPERATURES_C)
    for each in found:
        assert each["estimate"]["unit"] == "K"
        error = each["estimate"]["value"] - DEVIATION_K
        assert abs(error) < each["estimate"]["expanded_uncertainty_95"] < 0.1


def within(part):
    value, u = (part["result"][key] for key in ("value", "standard_uncertainty"))
    low, high = (part[key]["value"] for key in ("lower_limit", "upper_limit"))
    return min(value - low, high - value) / u


def test_one_verdict_over_all_points_names_the_worst(tested):
    """All conform as good as certainly: it is nearest to its limit in standard uncertainties."""
    decision = tested[1]["decision"]
    worst, *each = decision["parts"]
    assert len(each) == len(TEMPERATURES_C)
    assert {part["probability_of_conformity"] > 0.999 for part in each} == {True}
    least = min(each, key=within)
    assert worst["of"] == f"worst {least['of']}" == decision["of"]
    assert worst["coordinates"] == least["coordinates"]


def test_each_resistance_is_found_with_its_uncertainty(tested):
    found = [each for each in tested[1]["results"] if each["name"] == "resistance"]
    at = [each["coordinates"]["chamber.temperature"] for each in found]
    assert at == [{"value": t, "unit": "°C"} for t in TEMPERATURES_C]
    for each, t in zip(found, TEMPERATURES_C, strict=True):
        estimate = each["estimate"]
        assert estimate["unit"] == "Ω"
        assert estimate["value"] == pytest.approx(platinum(t + DEVIATION_K), abs=0.02)
        assert estimate["standard_uncertainty"] > 0.010 / sqrt(3)
        assert each["readings"] == 5
        assert [line["name"] for line in each["budget"]] == [
            "scatter of the readings", "reading of meter.resistance",
        ]  # fmt: skip


def test_it_passes_and_the_report_shows_each_point_with_its_limit(tested):
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


def test_the_archive_finds_it_by_its_temperature(tested, tmp_path):
    database = ("--database", tmp_path / "archive.sqlite")
    assert call("archive", "index", tested[0].parent, *database).code == 0
    wanted = ("--result", "deviation=0.05..0.15 K", "--where", "temperature=100 °C")
    found = call("archive", "search", *wanted, *database)
    assert re.search(
        r"deviation +chamber\.temperature = 100 °C +0\.\d+ ± 0\.\d+ K +pass", found.out
    )
    assert found.err == "1 result\n"


def test_a_notebook_has_the_results(tested):
    rows = open_run(tested[0]).results
    assert rows.column("place")[:4] == [f"chamber.temperature = {t:g} °C" for t in TEMPERATURES_C]
    stated = [each["estimate"]["value"] for each in tested[1]["results"]]
    assert rows.column("value") == stated
    assert analyse(tested[0]).results == rows


@pytest.mark.usefixtures("drawn_figures")
def test_a_notebook_draws_the_figures_of_the_report(tested):
    (values,) = open_run(tested[0]).plot_results("deviation").figure.axes
    stated = [
        each["estimate"]["value"] for each in tested[1]["results"] if each["name"] == "deviation"
    ]
    assert list(values.lines[0].get_ydata()) == pytest.approx(stated)
    assert values.get_ylabel() == "d / K"
    with pytest.raises(UsageError, match="no result 'resistanse'"):
        open_run(tested[0]).plot_results("resistanse")


@pytest.mark.thorough
def test_another_statistic_moves_the_results_and_golden_runs_tell(tested, tmp_path):
    changed, golden = tmp_path / "analysis.yaml", tmp_path / "golden"
    changed.write_text(MAXIMUM, encoding="utf-8")
    one = ("--jobs", "1")
    assert call("golden", "record", tested[0].parent, "--out", golden, *one).code == 0
    assert "No change in 1 golden run" in call("golden", "check", golden, *one).out
    page = tmp_path / "golden.html"
    found = call("golden", "check", golden, *one, "--analysis", changed, "--json", "--html", page)
    assert found.code == 1, found.err
    (run,) = json.loads(found.out)["runs"]
    moves = {each["figure"]: each for each in run["moves"]}
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


def test_reanalyse_has_a_line_for_each_result(tested, tmp_path):
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
