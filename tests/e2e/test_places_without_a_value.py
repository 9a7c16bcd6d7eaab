"""A run with a place where a result has no value: verdict, files, report, certificate, archive."""

from __future__ import annotations

import json
import re

import h5py
import pytest

from helpers_any_quantity import STATION, written
from helpers_certificate import make_letterhead
from helpers_cli import call
from helpers_figures import drawn

EQUATION = """\
rigrunner: procedure/2
id: PSU-R
revision: "A"
title: Resistance of a load
inputs: {specimen: {ask: Serial number, unattended: PSU-1}}
uses: {bench: supply_bench}
main:
  - sweep:
      set: bench.current
      over: [0 A, 1 A, 2 A]
      steps: [{measure: {channels: [bench.voltage]}}]
analysis:
  - equation:
      result: {name: resistance, symbol: R, unit: Ω}
      per: bench.current
      inputs: {U: bench.voltage, I: bench.current}
      model: R = U / I
acceptance:
  limits:
    - {of: resistance, LIMIT, min: 5 Ω, max: 13 Ω, source: sheet}
"""
CURVE = (
    EQUATION.replace(
        "over: [0 A, 1 A, 2 A]", "over: [0 A, 1 A, 2 A, 5 A]\n      label: {run: long}"
    )
    .replace(
        "analysis:\n",
        """\
  - sweep:
      set: bench.current
      over: [0 A, 1 A, 2 A]
      label: {run: short}
      steps: [{measure: {channels: [bench.voltage]}}]
analysis:
""",
    )
    .split("  - equation:")[0]
    + """\
  - curve:
      of: bench.voltage
      over: bench.current
      fit: {polynomial: {degree: 1}}
      per: run
      results: {x_at: {name: current, unit: A, y: 11.99 V}}
acceptance:
  limits:
    - {of: current, LIMIT, max: 9 A, source: sheet}
"""
)
NO_VALUE = "There is no value of resistance at bench.current = 0 A: 'U / I' gives no finite number"


def run_with_limit(folder, limit, procedure=EQUATION):
    paths = written(folder, procedure=procedure.replace("LIMIT", limit), station=STATION)
    procedure_path, station = paths
    called = call(
        "run", procedure_path, "--station", station, "--unattended", "--runs", folder / "runs"
    )
    (run,) = (folder / "runs").iterdir()
    return called, run


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    return run_with_limit(tmp_path_factory.mktemp("missing"), "each: bench.current")


def strict_json(path):
    """Return the content of a JSON file, in which NaN is an error."""

    def refuse(text):
        raise AssertionError(text)

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def test_results_of_other_places_remain_and_the_run_is_undecided(judged):
    called, run = judged
    assert called.code == 10, called.err
    document = strict_json(run / "result.json")
    assert [each["coordinates"]["bench.current"]["value"] for each in document["results"]] == [1, 2]
    assert all(result["budget"] for result in document["results"])
    (missing,) = document["missing"]
    assert missing["coordinates"]["bench.current"] == {"value": 0.0, "unit": "A"}
    assert missing["why"] == "'U / I' gives no finite number"
    parts = {part["of"]: part for part in document["decision"]["parts"]}
    assert {name: part["verdict"] for name, part in parts.items()} == {
        "resistance at bench.current = 0 A": "inconclusive",
        "resistance at bench.current = 1 A": "pass",
        "resistance at bench.current = 2 A": "pass",
    }
    missing_part = parts["resistance at bench.current = 0 A"]
    assert missing_part["result"] is None
    assert missing_part["probability_of_conformity"] is None
    assert missing_part["reason"].startswith(NO_VALUE)
    assert "no value" in called.out


CURVED = (
    EQUATION.split("analysis:", maxsplit=1)[0]
    + """\
analysis:
  - equation:
      result: {name: steep, unit: 1/V}
      model: 1 / (U - U_0)
      inputs: {U: bench.voltage}
      constants: {U_0: 12.0218 V}
      per: bench.current
  - equation:
      result: {name: twice, unit: 1/V}
      model: 2 * steep
      inputs: {steep: steep}
      per: bench.current
  - readings: {of: bench.voltage, per: bench.current, result: {name: voltage, unit: V}}
acceptance:
  limits:
    - {of: steep, each: bench.current, max: 9000 1/V, source: sheet}
    - {of: steep, mean: yes, max: 9000 1/V, source: sheet}
    - {of: twice, each: bench.current, max: 19000 1/V, source: sheet}
    - {of: voltage, each: bench.current, max: 13 V, source: sheet}
"""
)


def test_failed_trial_leaves_its_place_and_derived_results_undecided(tmp_path):
    """At 1 A the divisor is 0.2 mV ± 0.2 mV: no slope describes the spread of its reciprocal."""
    station = STATION.replace("accuracy: 2 mV", "accuracy: 0.2 mV")
    procedure, bench = written(tmp_path, procedure=CURVED, station=station)
    called = call("run", procedure, "--station", bench, "--unattended", "--runs", tmp_path / "runs")
    assert called.code == 10, called.err
    (run,) = (tmp_path / "runs").iterdir()
    parts = {part["of"]: part for part in strict_json(run / "result.json")["decision"]["parts"]}
    undecided = {name for name, part in parts.items() if part["verdict"] == "inconclusive"}
    assert undecided == {
        "mean steep", "steep at bench.current = 1 A", "twice at bench.current = 1 A",
    }  # fmt: skip
    assert len(parts) == 10
    assert {part["verdict"] for name, part in parts.items() if name not in undecided} == {"pass"}
    for name in undecided:
        assert "Monte Carlo of steep' failed" in parts[name]["reason"]
        assert parts[name]["probability_of_conformity"] is None


@pytest.mark.parametrize(
    ("limit", "code"),
    [
        ("where: {bench.current: [1 A, 2 A]}, each: bench.current", 0),
        ("where: {bench.current: 0 A}", 10),
        ("mean: yes", 10),
        ("worst: yes", 10),
    ],
)
def test_only_limits_that_need_the_missing_place_are_inconclusive(tmp_path, limit, code):
    called, run = run_with_limit(tmp_path, limit)
    assert called.code == code, called.out + called.err
    document = strict_json(run / "result.json")
    if code:
        assert NO_VALUE in document["verdict"]["reason"]


def test_curve_without_a_value_at_one_place(tmp_path):
    called, run = run_with_limit(tmp_path, "each: run", CURVE)
    assert called.code == 10, called.err
    document = strict_json(run / "result.json")
    assert [result["coordinates"] for result in document["results"]] == [{"run": "long"}]
    assert [result["coordinates"] for result in document["missing"]] == [{"run": "short"}]
    assert {part["of"]: part["verdict"] for part in document["decision"]["parts"]} == {
        "current at run = long": "pass",
        "current at run = short": "inconclusive",
    }


def test_run_without_any_value_is_reported(tmp_path):
    procedure = EQUATION.replace("[0 A, 1 A, 2 A]", "[0 A]")
    called, run = run_with_limit(tmp_path, "each: bench.current", procedure)
    assert called.code == 10, called.err
    assert "<td>no value</td>" in (run / "report.html").read_text(encoding="utf-8")


def test_report_and_sealed_file_show_no_number_at_the_missing_place(judged):
    _, run = judged
    page = (run / "report.html").read_text(encoding="utf-8")
    section = page.split('<section id="results">')[1].split("</section>")[0]
    (row,) = re.findall(r"<tr[^>]*><th[^>]*>0 A</th>.*?</tr>", section, re.DOTALL)
    assert "<td>no value</td><td></td>" in row
    assert "inconclusive" in row
    assert NO_VALUE.replace("'", "&#39;") in page
    assert not re.search(r"\bnan\b", re.sub(r"<[^>]*>", " ", section), re.IGNORECASE)
    with h5py.File(run / "run.h5") as file:
        texts = []
        file.visititems(
            lambda _, node: texts.append(node[()]) if isinstance(node, h5py.Dataset) else None
        )
    sealed = b"".join(each for each in texts if isinstance(each, bytes))
    assert b"NaN" not in sealed


@pytest.mark.thorough
def test_certificate_is_inconclusive_there_and_verifies(judged, tmp_path):
    _, run = judged
    letterhead = make_letterhead(tmp_path / "letterhead")
    with drawn():
        called = call(
            "certify", run, "--letterhead", letterhead, "--authorised-by", "A. Nother",
            "--customer", "C", "--customer-contact", "D", "--item", "I", "--item-id", "1",
            "--item-condition", "new", "--received", "2020-01-01", "--operator", "O",
            "--not-for-certification", "--out", tmp_path / "out",
        )  # fmt: skip
        assert called.code == 0, called.err
        (path,) = (tmp_path / "out").glob("*.json")
        content = strict_json(path)
        assert content["conformity"]["verdict"] == "inconclusive"
        first = content["conformity"]["statements"][0]
        assert first["of"] == "resistance at bench.current = 0 A"
        assert first["printed_result"] == ""
        assert len(content["named"]) == 2
        assert any(deviation["text"].startswith(NO_VALUE) for deviation in content["deviations"])
        for form in (tmp_path / "out").iterdir():
            called = call("verify", form, "--runs", run.parent, "--letterhead", letterhead)
            assert called.code == 0, called.out + called.err


def test_run_can_be_decided_again_and_found_in_the_archive(judged, tmp_path):
    _, run = judged
    words = ["--by", "N", "--reason", "new sheet", "--rule", "guard_band_u"]
    called = call("decide", run, *words)
    assert called.code == 10, called.err
    runs = run.parent
    database = ("--database", tmp_path / "archive.sqlite")
    called = call("archive", "index", runs, *database)
    assert called.code == 0, called.err
    called = call("archive", "search", *database, "--verdict", "inconclusive")
    assert run.name in called.out, called.out + called.err
    called = call("show", run)
    assert called.code == 0, called.err
    assert "no value at bench.current = 0 A" in called.out
