"""The keys of a rig that a station of the bearings may have."""

from __future__ import annotations

from helpers_language import PROCEDURE, STATION, edited, only_problem, place_of
from rigrunner.plan import check_partners
from rigrunner.procedure import parse_procedure
from rigrunner.registry import load_registry
from rigrunner.station import parse_station


def test_what_ships_declares_the_rig_of_bearings():
    assert {"mandrel", "eccentric"} <= set(load_registry().rig_model().model_fields)


def test_a_mandrel_that_both_runs_must_share_is_asked_for():
    station = edited(STATION, ("  mandrel: M-01\n", ""))
    parsed = parse_procedure(PROCEDURE, "p.yaml"), parse_station(station, "s.yaml")
    problem = only_problem(lambda: check_partners(*parsed, load_registry()))
    assert problem.message == "the analysis needs the key 'mandrel' of the rig, which is missing"
    assert str(problem.location) == f"s.yaml:{place_of(station, 'rig:')}"
    assert problem.hint == f"it is needed at p.yaml:{place_of(PROCEDURE, 'no_load:')}"
