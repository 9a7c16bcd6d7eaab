"""Named results in an archive, on both engines: by name, value and coordinates."""

from __future__ import annotations

from contextlib import closing

import pytest

from e2e.helpers_trends import on_day
from rigrunner.api.errors import UsageError
from rigrunner_fleet.archive import index, open_archive, query
from rigrunner_fleet.archive.filters import Filters
from rigrunner_fleet.monitoring.gauge import read_sessions
from rigrunner_fleet.monitoring.observing import observe
from unit.rigrunner_fleet.archive.helpers_archive import store_run
from unit.rigrunner_fleet.archive.helpers_named_results import (
    resistance_document,
    store_resistances,
)


@pytest.fixture
def archived(database, runs):
    store_resistances(runs, "good", {0.0: 100.02, 100.0: 138.53}, started_utc=on_day(1))
    store_resistances(runs, "bad", {0.0: 100.02, 100.0: 138.95}, "mΩ", started_utc=on_day(2))
    store_run(runs, "torque")
    with closing(open_archive(database=database)) as archive:
        index(archive, [runs])
    return database


def results_of(database, **filters):
    rows = query("results", database=database, **filters)
    return [(row["run_id"], row["place"], row["value"], row["unit"]) for row in rows]


def test_results_are_stored_as_stated_with_limits_and_verdict(archived):
    (row,) = query("results", database=archived, result="resistance", where={"temperature": 100},
                   verdict="fail")  # fmt: skip
    expected = {
        "run_id": "bad", "name": "resistance", "symbol": "R", "unit": "mΩ",
        "measurand": "resistance of the sensor", "place": "chamber.temperature = 100 °C",
        "value": 138950.0, "u": 5.0, "expanded": 10.0, "dof": float("inf"), "readings": 5,
        "lower": 138203.0, "upper": 138808.0, "verdict": "fail", "si_unit": "Ω",
    }  # fmt: skip
    assert {name: row[name] for name in expected} == expected
    assert row["si_value"] == pytest.approx(138.95)


def store_at(runs, name, value, unit, day, **more):
    """Store a run with a resistance at one position of a stage."""
    document = resistance_document({100.0: 138.5 + 0.01 * day})
    place = {"stage.x": {"value": value, "unit": unit}, **more}
    document["results"][0]["coordinates"] = place
    document["decision"]["parts"][0]["coordinates"] = place
    inputs = {"specimen": f"P{day % 2}", "operator": f"O{day // 2 % 2}"}
    store_run(runs, name, document, recordings=0, started_utc=on_day(day), inputs=inputs)


def test_place_is_stated_in_the_unit_of_the_procedure(database, runs):
    store_at(runs, "r", 0.5, "mm", 1)
    store_at(runs, "s", 45.0, "°", 2)
    with closing(open_archive(database=database)) as archive:
        index(archive, [runs])
    places = [row["place"] for row in query("results", database=database)]
    assert places == ["stage.x = 0.5 mm", "stage.x = 45 °"]
    (row,) = query("coordinates", database=database, where={"x": "0.0005 m"})
    assert (row["value"], row["unit"], row["text"]) == (0.0005, "m", "0.5 mm")
    assert results_of(database, where={"x": "500 µm"})[0][0] == "r"
    assert query("results", database=database, where={"x": "500 µm"}).column("upper") == [138.808]


def test_places_in_several_units_are_one_as_the_newest_run_states_it(database, runs):
    label = {"state": "slow, at 3 = 4 V"}
    for day in range(8):
        value, symbol = ((0.5, "mm"), (500.0, "µm"))[day // 4]
        store_at(runs, f"day-{day}", value, symbol, day, **label)
    store_at(runs, "other", 0.6, "mm", 8, **label)
    with closing(open_archive(database=database)) as archive:
        index(archive, [runs])
        observations = observe(archive, "resistance", Filters())
        sessions = read_sessions(archive, "resistance", Filters())
    counts = {name: len(group.observed) for name, group in observations.groups.items()}
    state = "state = slow, at 3 = 4 V"
    at = "type not stated, lot not stated, stage.x = "
    assert counts == {f"{at}500 µm, {state}": 8, f"{at}0.6 mm, {state}": 1}
    assert sessions.places == {"stage.x = 0.5 mm", "stage.x = 0.6 mm"}


@pytest.mark.parametrize(
    "where",
    [
        {"chamber.temperature": "100 °C"}, {"temperature": "373.15 K"}, {"temperature": 100},
        {"temperature": "212 °F"},
    ],
)  # fmt: skip
def test_coordinate_matches_in_any_unit_and_without_role(archived, where):
    at_100 = "chamber.temperature = 100 °C"
    assert results_of(archived, where=where) == [
        ("good", at_100, 138.53, "Ω"), ("bad", at_100, 138950.0, "mΩ"),
    ]  # fmt: skip
    assert len(query(database=archived, where=where)) == 2


@pytest.mark.parametrize(
    "where", [{"temperature": "100 Hz"}, {"chamber": "100 °C"}, {"temperature": "warm"},
              {"temperature": 99}]
)  # fmt: skip
def test_other_coordinates_match_nothing(archived, where):
    assert results_of(archived, where=where) == []
    assert len(query(database=archived, where=where)) == 0


def test_result_range_applies_in_any_unit_at_the_given_coordinate(archived):
    limits = {"resistance": "138.9..139 Ω"}
    assert [run for run, *_ in results_of(archived, result=limits)] == ["bad"]
    assert results_of(archived, result=limits, where={"temperature": 0}) == []
    assert query(database=archived, result=limits).column("run_id") == ["bad"]
    assert results_of(archived, result={"resistance": "138.9..139 V"}) == []
    assert len(query(database=archived, result=["resistance", "air"])) == 0, (
        "a run must have all of them"
    )


def test_invalid_coordinate_is_refused(archived):
    with pytest.raises(UsageError, match="'100 Grad'"):
        results_of(archived, where={"temperature": "100 Grad"})


def test_study_counts_runs_with_failed_checks_not_values(database, runs):
    ohms = {0.0: 100.02, 100.0: 138.53}
    store_resistances(runs, "good", ohms)
    failed = {"name": "zero", "ok": False}
    store_run(runs, "doubtful", resistance_document(ohms) | {"checks": [failed]})
    with closing(open_archive(database=database)) as archive:
        index(archive, [runs])
        observations = observe(archive, "resistance", Filters())
    assert "1 of 2 runs did not pass all checks of the analysis" in observations.warnings
