"""Trends, capabilities and gauge studies from the command line, and mistakes in asking."""

from __future__ import annotations

import json

import numpy as np
import pytest

from e2e.helpers_trends import index_all, on_day, store_results
from helpers_cli import call
from unit.rigrunner_fleet.archive.helpers_archive import estimate, result_document, store_run

SHIFTED_FROM = 34


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Forty runs of one lot with a shift of the torque, and three that do not count."""
    runs = tmp_path_factory.mktemp("trends") / "runs"
    rng = np.random.default_rng(5)
    torques = 0.72 + 0.01 * rng.normal(size=40)
    torques[SHIFTED_FROM:] += 0.05
    store_results(runs, torques, frequencies=400 + 0.1 * rng.normal(size=40))
    inputs = {"type": "GE20", "lot": "L1"}
    store_run(runs, "void", {"measurand": {"name": "none"}}, inputs=inputs)
    (runs / "bad").mkdir()
    (runs / "bad" / "run.h5").write_text("no")
    few = result_document(0.9)
    few["no_load_run"] = {"id": "no-load 39"}
    figures = few["compensations"]["template_inverse"]["parameters"]
    figures["inertia"] = estimate(0.00232 + 1e-7 * (7 * 40 % 13), 1e-6, "kg·m²")
    store_run(runs, "few", few, started_utc=on_day(41), inputs={"type": "GE20", "lot": "L2"})
    index_all(runs)
    return runs


def test_shift_is_reported_with_its_rule(folder):
    done = call("trend", "torque", "--runs", folder)
    assert done.code == 1
    assert "type GE20, lot L1" in done.out
    assert "OUT OF CONTROL" in done.out
    assert "Nelson 1: one value beyond 3 standard deviations" in done.out
    assert "No chart of type GE20, lot L2: there is 1 value, and the baseline is" in done.out
    assert "1 left out: it has no such value" in done.out
    assert "note: 41 of 41 runs did not pass all checks of the analysis" in done.out


def test_limits_are_those_of_the_baseline(folder):
    charts = json.loads(call("trend", "torque", "--runs", folder, "--json").out)
    (series,) = charts["series"]
    values = [point["observed"]["value"] for point in series["points"]]
    mean_range = np.abs(np.diff(values[:20])).mean()
    assert series["individuals"]["centre"] == pytest.approx(np.mean(values[:20]))
    assert series["individuals"]["upper"] == pytest.approx(
        np.mean(values[:20]) + 3 * mean_range / 1.128379, rel=1e-6
    )
    assert [point["baseline"] for point in series["points"]] == [True] * 20 + [False] * 20
    first = next(i for i, point in enumerate(series["points"]) if i > 19 and point["rules"])
    assert first in range(SHIFTED_FROM, SHIFTED_FROM + 2)
    assert series["points"][0]["observed"]["expanded"] == pytest.approx(0.01)


def test_baseline_by_dates_gives_the_same_limits(folder):
    of_days = ("--baseline", "2026-01-01..2026-01-20")
    first = json.loads(call("trend", "torque", "--runs", folder, "--json").out)["series"]
    dated = json.loads(call("trend", "torque", "--runs", folder, "--json", *of_days).out)["series"]
    assert first[0]["individuals"] == dated[0]["individuals"]


def test_process_in_control_exits_with_0(folder):
    done = call("trend", "fn", "--runs", folder, "--chart", "ewma")
    assert done.code == 0, done.out
    assert "In control: no rule is met at 20 values after the baseline." in done.out
    assert call("trend", "torque", "--runs", folder, "--until", "2026-01-30").code == 0


def test_figures_of_one_no_load_run_count_once_only(folder):
    """The run 'few' has the no-load run of the last day, and with it the same inertia."""
    charts = json.loads(call("trend", "J", "--runs", folder, "--baseline", "10", "--json").out)
    reasons = [run["reason"] for run in charts["excluded"] if run["run_id"] == "few"]
    assert reasons == ["its value is that of day-39: the same no-load run"]


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        (["torqe"], 2, "no matching run has a result or figure 'torqe'"),
        (["torque", "--baseline", "5"], 2, "a baseline of 5 values is too short"),
        (["torque", "--baseline", "yesterday"], 2, "'yesterday' is not a baseline"),
        (["torque", "--baseline", "2026-02-01..2026-01-01"], 2, "is empty"),
        (["torque", "--baseline", "2026-01-01..2026-01-05"], 5, "too short for limits"),
        (
            ["torque", "--baseline", "50"],
            5,
            "there are 40 values, and the baseline is the first 50",
        ),
        (["torque", "--limit", "30"], 2, "--limit does not go with a study"),
        (["torque", "--lot", "L9"], 5, "no matching run"),
        (["torque", "--by", "colour"], 2, "Invalid value for '--by'"),
        (["torque", "--out", "no/trend.docx"], 2, "no report is written as 'trend.docx'"),
    ],
)
def test_impossible_chart_is_refused_with_a_message(folder, words, code, told):
    done = call("trend", *words, "--runs", folder)
    assert (done.code, "Traceback" in done.err) == (code, False), done.err
    assert told in done.err


def test_results_of_several_procedures_are_not_mixed(tmp_path):
    for number in range(24):
        procedure = "SSPB-A" if number % 2 else "SSPB-B"
        store_run(
            tmp_path / "runs",
            f"r{number}",
            result_document(0.7 + number / 1000),
            procedure_id=procedure,
            recordings=0,
        )
    index_all(tmp_path / "runs")
    done = call("trend", "torque", "--runs", tmp_path / "runs")
    assert done.code == 5
    assert "SSPB-A by template_inverse (12), SSPB-B by template_inverse (12)" in done.err


@pytest.fixture(scope="module")
def of_two_rigs(tmp_path_factory):
    """Two dozen runs in turn on two rigs, with two mandrels."""
    runs = tmp_path_factory.mktemp("of_two_rigs") / "runs"
    for number in range(24):
        document = result_document(0.7)
        document["no_load_run"] = {"id": f"no-load {number}"}
        document["run"] = {"mandrel": "M-01" if number % 4 < 2 else "M-02"}
        store_run(runs, f"r{number}", document, started_utc=on_day(number),
                  station_id="a" if number % 2 else "b", recordings=0)  # fmt: skip
    index_all(runs)
    return runs


@pytest.mark.parametrize(
    ("quantity", "by", "told"),
    [
        (
            "J",
            ["--by", "rig"],
            "figures of several rigs or mandrels: a with M-01 (6), a with M-02 (6)",
        ),
        (
            "J",
            ["--by", "mandrel"],
            "figures of several rigs or mandrels: a with M-01 (6), b with M-01",
        ),
        ("zero", ["--by", "procedure"], "figures of several rigs or mandrels: a (12), b (12)"),
    ],
)
def test_figures_of_several_rigs_or_mandrels_are_not_mixed(of_two_rigs, quantity, by, told):
    done = call("trend", quantity, *by, "--runs", of_two_rigs)
    assert done.code == 5
    assert told in done.err
    assert "--by rig --by mandrel" in done.err


def test_name_does_not_control_the_terminal(tmp_path):
    store_results(tmp_path / "runs", [0.7, 0.71] * 12, lot="\x1b[31mred")
    index_all(tmp_path / "runs")
    for words in (["--rules", "shewhart"], ["--baseline", "30"]):
        done = call("trend", "torque", *words, "--runs", tmp_path / "runs")
        assert "[31mred" in done.out + done.err
        assert "\x1b" not in done.out + done.err


def test_figure_of_two_compensations_needs_both_names(tmp_path):
    for number in range(12):
        document = result_document(0.7)
        document["no_load_run"] = {"id": f"no-load {number}"}
        inertia = {"inertia": estimate(0.0023 + 1e-6 * (5 * number % 7), 1e-6, "kg·m²")}
        document["compensations"]["template_inverse"]["parameters"] = inertia
        document["compensations"]["energy"] = {"checks": [], "parameters": inertia, "points": []}
        store_run(
            tmp_path / "runs", f"r{number}", document, started_utc=on_day(number), recordings=0
        )
    index_all(tmp_path / "runs")
    asked = ("--baseline", "12", "--runs", tmp_path / "runs")
    done = call("trend", "J", *asked)
    assert done.code == 2
    assert "several figures are called 'J'" in done.err
    assert "name one: energy/inertia, template_inverse/inertia" in done.err
    assert call("trend", "energy/inertia", *asked).code == 0


def test_capability_has_its_interval_and_warnings(folder):
    done = call("capability", "torque", "--upper", "0.95 N·m", "--runs", folder)
    assert done.code == 0, done.err
    assert "Cpu" in done.out
    assert "the process was not in control" in done.out
    studies = json.loads(
        call("capability", "torque", "--upper", "0.95 N·m", "--lower", "0.5 N·m",
             "--until", "2026-01-30", "--runs", folder, "--json").out
    )  # fmt: skip
    indices = {index["name"]: index for index in studies["series"][0]["capability"]["indices"]}
    assert list(indices) == ["Cp", "Cpk", "Cpu", "Cpl"]
    assert all(index["low"] < index["value"] < index["high"] for index in indices.values())
    assert "in control" not in str(studies["series"][0]["warnings"])


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        ([], 5, "the runs have no limit of it"),
        (["--upper", "0.95"], 2, "'0.95' has no unit"),
        (["--upper", "5 Hz"], 2, "'5 Hz' is a frequency, and the values are in N·m"),
        (["--upper", "0.2 N·m", "--lower", "0.3 N·m"], 5, "is not below the upper one"),
    ],
)
def test_capability_without_a_fitting_limit_is_refused(folder, words, code, told):
    done = call("capability", "torque", *words, "--runs", folder)
    assert done.code == code
    assert told in done.err


def store_session(runs, part, operator, torques, **header):
    document = result_document(float(np.mean(torques)))
    point = document["points"][0]
    document["points"] = [point] * len(torques)
    compensation = document["compensations"]["template_inverse"]
    (first, *_) = compensation["points"]
    compensation["points"] = [{**first, "torque": estimate(float(torque))} for torque in torques]
    store_run(
        runs,
        f"{part} by {operator}",
        document,
        inputs={"specimen": part, "operator": operator},
        **header,
    )


@pytest.fixture(scope="module")
def sessions(tmp_path_factory):
    """Three parts by two operators, three trials of each."""
    runs = tmp_path_factory.mktemp("gauge") / "runs"
    for part, torque in (("P1", 0.6), ("P2", 0.7), ("P3", 0.8)):
        for operator, shift in (("A", 0.0), ("B", 0.01)):
            store_session(runs, part, operator, torque + shift + np.array([-0.002, 0.0, 0.002]))
    index_all(runs)
    return runs


def test_gauge_study_of_sessions(sessions):
    done = call("gauge-rr", "--runs", sessions, "--tolerance", "0.5 N·m")
    assert done.code == 0, done.err
    assert "3 parts x 2 operators x 3 trials" in done.out
    study = json.loads(call("gauge-rr", "--runs", sessions, "--json").out)
    assert study["readings"][1][1] == pytest.approx([0.708, 0.71, 0.712])
    components = study["analysis"]["components"]
    # by hand: no interaction, so its 2 dof are pooled with those of the error: 12 x 0.002^2 / 14
    error = 12 * 0.002**2 / 14
    assert components["repeatability"] ** 2 == pytest.approx(error)
    assert components["operator"] ** 2 == pytest.approx((9 * 2 * 0.005**2 - error) / 9)
    assert components["part"] ** 2 == pytest.approx((6 * 0.1**2 * 2 / 2 - error) / 6)


def test_incomplete_study_names_what_is_missing(tmp_path):
    runs = tmp_path / "runs"
    store_session(runs, "P1", "A", [0.6, 0.61])
    store_session(runs, "P1", "B", [0.6, 0.61])
    index_all(runs)
    assert "1 part and 2 operators are not a crossed study" in call("gauge-rr", "--runs", runs).err
    store_session(runs, "P2", "A", [0.7, 0.72, 0.71])
    index_all(runs)
    done = call("gauge-rr", "--runs", runs)
    assert done.code == 5
    assert "the study is not crossed: P2 by B is missing" in done.err
    store_session(runs, "P2", "B", [0.7, 0.72])
    index_all(runs)
    assert "most have 2 trials, P2 by A has 3" in call("gauge-rr", "--runs", runs).err


def test_sessions_on_two_rigs_are_two_studies(tmp_path):
    for rig in ("a", "b"):
        store_session(tmp_path / rig, "P1", "A", [0.6, 0.61], station_id=rig)
    index_all(tmp_path)
    done = call("gauge-rr", "--runs", tmp_path)
    assert done.code == 2
    assert "on a (1)" in done.err
    assert "--procedure or --rig" in done.err


def test_figure_in_two_units_is_not_one_chart(tmp_path):
    """A polynomial that is stated in mN·m from one day on is no change of the rig."""
    runs = tmp_path / "runs"
    for day in range(24):
        document = result_document(0.72)
        document["no_load_run"] = {"id": f"no-load {day}"}
        value, unit = (0.9 + day / 1000, "N·m") if day < 12 else (900.0 + day, "mN·m")
        coefficients = {"c0": estimate(value, value / 10, unit)}
        document["fits"][0]["curve"]["coefficients"] = coefficients
        store_run(runs, f"day-{day:02d}", document, started_utc=on_day(day), recordings=0)
    index_all(runs)
    done = call("trend", "c0", "--runs", runs)
    assert done.code == 2
    assert "'c0' is in N·m and in mN·m" in done.err
