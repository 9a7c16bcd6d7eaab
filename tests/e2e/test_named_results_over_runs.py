"""Trends, capabilities and gauge studies of a named result: a resistance at two temperatures."""

from __future__ import annotations

import json
from itertools import product
from math import sqrt

import numpy as np
import pytest

from e2e.helpers_trends import index_all, on_day
from helpers_cli import call
from unit.rigrunner_fleet.archive.helpers_archive import estimate, store_run
from unit.rigrunner_fleet.archive.helpers_named_results import (
    resistance_document,
    store_resistances,
)

SHIFTED_FROM = 24
LIMITS = ("--lower", "138.203 Ω", "--upper", "138808 mΩ")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Thirty runs of one lot, with a shift at 100 °C only, the last stated in mΩ."""
    runs = tmp_path_factory.mktemp("named") / "runs"
    rng = np.random.default_rng(3)
    cold, warm = 100.02 + 0.004 * rng.normal(size=30), 138.52 + 0.004 * rng.normal(size=30)
    warm[SHIFTED_FROM:] += 0.05
    for day, (at_0, at_100) in enumerate(zip(cold, warm, strict=True)):
        store_resistances(
            runs, f"day-{day:02d}", {0.0: at_0, 100.0: at_100}, "mΩ" if day == 29 else "Ω",
            started_utc=on_day(day), inputs={"type": "Pt100", "lot": "L1"},
        )  # fmt: skip
    index_all(runs)
    return runs, warm


def test_each_place_has_a_chart_and_only_the_shifted_one_fails(folder):
    done = call("trend", "resistance", "--runs", folder[0], "--json")
    assert done.code == 1
    charts = json.loads(done.out)
    cold, warm = charts["series"]
    group = "type Pt100, lot L1, chamber.temperature ="
    assert [cold["name"], warm["name"]] == [f"{group} 0 °C", f"{group} 100 °C"]
    rules_met = [[bool(point["rules"]) for point in series["points"]] for series in (cold, warm)]
    assert not any(rules_met[0][20:])
    assert all(rules_met[1][SHIFTED_FROM + 1 :])


def test_values_have_their_uncertainty_in_the_unit_of_the_newest_run(folder):
    options = ("--runs", folder[0], "--where", "temperature=100 °C")
    charts = json.loads(call("trend", "resistance", *options, "--json").out)
    assert charts["unit"] == "mΩ"
    (series,) = charts["series"]
    assert [point["observed"]["value"] for point in series["points"]] == pytest.approx(
        1000 * folder[1], rel=1e-12
    )
    assert {round(point["observed"]["expanded"], 9) for point in series["points"]} == {10.0}


def test_chart_and_capability_are_written_as_pages(folder, tmp_path):
    runs = ("--runs", folder[0], "--where", "temperature=100")
    assert call("trend", "resistance", *runs, "--out", tmp_path / "trend.html").code == 1
    page = (tmp_path / "trend.html").read_text(encoding="utf-8")
    assert "resistance" in page
    assert "mΩ" in page
    done = call("capability", "resistance", *runs, *LIMITS, "--out", tmp_path / "cap.html")
    assert done.code == 0, done.err
    assert "data:image/svg+xml" in (tmp_path / "cap.html").read_text(encoding="utf-8")


def test_capability_takes_limits_in_any_unit(folder):
    runs = ("--runs", folder[0], "--where", "temperature=100")
    studies = json.loads(call("capability", "resistance", *runs, *LIMITS, "--json").out)
    mean, deviation = np.mean(folder[1]), np.std(folder[1], ddof=1)
    (series,) = studies["series"]
    indices = {index["name"]: index["value"] for index in series["capability"]["indices"]}
    nearest = min(138.808 - mean, mean - 138.203)
    assert indices["Cpk"] == pytest.approx(nearest / (3 * deviation), rel=1e-9)
    refused = call("capability", "resistance", *runs, "--upper", "1 V")
    assert (refused.code, "the values are in mΩ" in refused.err) == (2, True)


def test_limits_default_to_those_of_the_runs_in_the_newest_unit(folder):
    studies = json.loads(call("capability", "resistance", "--runs", folder[0], "--json").out)
    assert (studies["lower"], studies["upper"]) == (None, None)
    cold, warm = studies["series"]
    assert (cold["lower"], cold["upper"]) == (99883.0, 100117.0)
    assert (warm["lower"], warm["upper"]) == (138203.0, 138808.0)
    asked = ("--runs", folder[0], "--where", "temperature=100", *LIMITS)
    given = json.loads(call("capability", "resistance", *asked, "--json").out)
    indices = [
        {index["name"]: index["value"] for index in series["capability"]["indices"]}
        for series in (warm, given["series"][0])
    ]
    assert indices[0] == pytest.approx(indices[1], rel=1e-9)
    printed = call("capability", "resistance", "--runs", folder[0]).out
    assert "lower limit 138203 mΩ, upper limit 138808 mΩ" in printed


def test_differing_limits_of_runs_have_to_be_given(tmp_path):
    for day in range(12):
        document = resistance_document({100.0: 138.5 + 0.001 * day})
        if day > 6:
            document["decision"]["parts"][0]["upper_limit"]["value"] = 139.0
        store_run(tmp_path, f"day-{day:02d}", document, started_utc=on_day(day), recordings=0)
    index_all(tmp_path)
    refused = call("capability", "resistance", "--runs", tmp_path)
    assert refused.code == 5
    assert "several limits: 7 with 138.203 or more and 138.808 or less; 5 with" in refused.err
    assert "--upper" in refused.err
    assert call("capability", "resistance", "--runs", tmp_path, "--upper", "139 Ω").code == 0


def test_unknown_result_is_refused_with_a_list_of_results(folder):
    refused = call("trend", "resistence", "--runs", folder[0])
    assert (refused.code, "has a result or figure 'resistence'" in refused.err) == (2, True)
    assert "there are: torque, raw_peak, resistance" in refused.err


PARTS, OPERATORS, TRIALS = 3, 2, 3


def gauge_runs(runs, temperatures=(100.0,)):
    """Store sessions with a result for each trial; return the readings."""
    rng = np.random.default_rng(8)
    shape = (PARTS, OPERATORS, TRIALS)
    part = rng.normal(size=(PARTS, 1, 1))
    interaction = 0.2 * rng.normal(size=(PARTS, OPERATORS, 1))
    readings = 138.5 + 0.05 * (part + interaction + 0.02 * rng.normal(size=shape))
    for p, o in product(range(PARTS), range(OPERATORS)):
        document = resistance_document(dict.fromkeys(temperatures, 138.5))
        document["results"] = [
            {
                **result,
                "coordinates": {**result["coordinates"], "trial": {"value": t + 1, "unit": "1"}},
                "estimate": {**result["estimate"], "value": float(readings[p, o, t])},
            }
            for t in range(TRIALS)
            for result in document["results"]
        ]
        inputs = {"specimen": f"P{p}", "operator": f"O{o}"}
        store_run(runs, f"{p}-{o}", document, inputs=inputs, recordings=0)
    index_all(runs)
    return readings


def test_gauge_study_takes_each_value_at_a_set_point_as_a_trial(tmp_path):
    readings = gauge_runs(tmp_path / "runs")
    runs = ("--runs", tmp_path / "runs", "--out", tmp_path / "gauge.html")
    done = call("gauge-rr", "resistance", *runs, "--tolerance", "605 mΩ", "--json")
    assert done.code == 0, done.err
    study = json.loads(done.out)
    assert (study["unit"], study["tolerance"]) == ("Ω", pytest.approx(0.605))
    assert np.array(study["readings"]) == pytest.approx(readings)
    repeatability = sqrt(readings.var(axis=2, ddof=1).mean())
    assert not study["analysis"]["pooled"]
    assert study["analysis"]["components"]["repeatability"] == pytest.approx(repeatability)
    assert "resistance" in (tmp_path / "gauge.html").read_text(encoding="utf-8")


def test_readings_at_several_set_points_are_refused(tmp_path):
    gauge_runs(tmp_path / "runs", (0.0, 100.0))
    refused = call("gauge-rr", "resistance", "--runs", tmp_path / "runs")
    assert refused.code == 2
    assert "readings at several set-points: chamber.temperature = 0 °C, " in refused.err
    assert "choose by --where" in refused.err
    unknown = call("gauge-rr", "resistence", "--runs", tmp_path / "runs")
    assert "no matching run has a result 'resistence'" in unknown.err


def test_missing_value_at_one_place_is_excluded_with_its_reason(tmp_path):
    runs = tmp_path / "runs"
    for day in range(12):
        document = resistance_document(
            {0.0: 100 + 0.001 * (day % 5), 100.0: 138.5 + 0.001 * (day % 7)}
        )
        if day == 3:
            document["results"][1]["estimate"]["value"] = None
        store_run(runs, f"day-{day:02d}", document, started_utc=on_day(day), recordings=0)
    index_all(runs)
    charts = json.loads(
        call("trend", "resistance", "--runs", runs, "--baseline", "10", "--json").out
    )
    assert [len(series["points"]) for series in charts["series"]] == [12, 11]
    reason = "it has no value at chamber.temperature = 100 °C"
    assert charts["excluded"] == [{"run_id": "day-03", "reason": reason}]


def test_session_with_a_missing_trial_is_excluded(tmp_path):
    runs = tmp_path / "runs"
    for part, by in product(("A", "B"), ("Xu", "Yi")):
        for session in range(3):
            document = resistance_document({0.0: 100 + 0.01 * session, 100.0: 138.5})
            document["results"][1]["estimate"]["value"] = None
            inputs = {"specimen": part, "operator": by}
            store_run(runs, f"{part}-{by}-{session}", document, inputs=inputs, recordings=0)
    index_all(runs)
    done = call("gauge-rr", "resistance", "--runs", runs)
    assert done.code != 0
    assert "12 left out: 1 of 2 trials have no value" in done.err


def test_separately_stated_minimum_and_maximum_are_both_limits(tmp_path):
    """Cpk is by the nearer limit, whichever comes first in the procedure."""
    runs, rng = tmp_path / "runs", np.random.default_rng(5)
    values = 100.5 + 0.2 * rng.normal(size=24)
    for day, value in enumerate(values):
        document = resistance_document({0.0: value})
        (part,) = document["decision"]["parts"]
        bound = {"verdict": "pass", "lower_limit": None, "upper_limit": None}
        document["decision"]["parts"] = [
            part | bound | {"lower_limit": {"value": 99.0, "unit": "Ω"}},
            part | bound | {"upper_limit": {"value": 102.0, "unit": "Ω"}},
            part | bound | {"upper_limit": {"value": 101.0, "unit": "Ω"}},
        ]
        store_run(runs, f"day-{day:02d}", document, started_utc=on_day(day), recordings=0)
    index_all(runs)
    (series,) = json.loads(call("capability", "resistance", "--runs", runs, "--json").out)["series"]
    indices = {index["name"]: index["value"] for index in series["capability"]["indices"]}
    deviation = values.std(ddof=1)
    assert indices["Cpk"] == pytest.approx((101 - values.mean()) / (3 * deviation))
    assert indices["Cp"] == pytest.approx((101 - 99) / (6 * deviation))


def test_equal_temperatures_in_two_units_do_not_scatter(tmp_path):
    """25.3 °C in K and back differs from 25.3 by 1e-14: a Cpk of 1e14 would be a rounding error."""
    runs = tmp_path / "runs"
    for day in range(12):
        document = resistance_document({0.0: 100.0})
        value, unit = (298.45, "K") if day % 2 == 0 else (25.3, "°C")
        document["results"][0]["estimate"] = estimate(value, 0.1, unit)
        store_run(runs, f"day-{day:02d}", document, started_utc=on_day(day), recordings=0)
    index_all(runs)
    for command in (["capability", "--upper", "30 °C"], ["trend", "--baseline", "10"]):
        done = call(command[0], "resistance", *command[1:], "--runs", runs)
        assert (done.code, done.out) == (5, "")
        assert "all the same" in done.err
