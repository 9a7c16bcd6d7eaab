"""The keys of a rig that a station of the bearings may have."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from pydantic import ValidationError

from helpers_language import PROCEDURE, STATION, edited, only_problem, place_of
from rigrunner.plan import check_partners
from rigrunner.procedure import parse_procedure
from rigrunner.registry import load_registry
from rigrunner.station import parse_station
from rigrunner_bearings.api.rig import RigDescription, planned_rig

RIG = {
    "mandrel": "M-01",
    "eccentric": "2 mm",
    "centre_distance": "45 mm",
    "inertia": "0.00233 kg·m²",
    "support_friction": "0.76 N·m",
    "support_damping": "0.31 N·m·s/rad",
}


def test_shipped_plugins_declare_rig_of_bearings():
    assert {"mandrel", "eccentric"} <= set(load_registry().rig_model().model_fields)


def test_mandrel_shared_by_both_runs_is_required():
    station = edited(STATION, ("  mandrel: M-01\n", ""))
    parsed = parse_procedure(PROCEDURE, "p.yaml"), parse_station(station, "s.yaml")
    problem = only_problem(lambda: check_partners(*parsed, load_registry()))
    assert problem.message == "the analysis needs the key 'mandrel' of the rig, which is missing"
    assert str(problem.location) == f"s.yaml:{place_of(station, 'rig:')}"
    assert problem.hint == f"it is needed at p.yaml:{place_of(PROCEDURE, 'no_load:')}"


def test_ratio_of_the_rig():
    assert RigDescription.model_validate(RIG).eccentric_ratio == pytest.approx(2 / 45, rel=1e-15)


@pytest.mark.parametrize(
    ("key", "value"),
    [("eccentric", "0 mm"), ("eccentric", "45 mm"), ("eccentric", "50 mm"), ("inertia", "0 kg·m²"),
     ("support_friction", "-1 N·m"), ("swing_radius", "0 mm"), ("mandrel", 5)],
)  # fmt: skip
def test_impossible_rig_is_refused(key, value):
    with pytest.raises(ValidationError):
        RigDescription.model_validate(RIG | {key: value})


def test_invalid_rig_is_replaced_by_stand_in():
    """`check` reports the mistake itself."""
    planned = SimpleNamespace(rig_keys=RIG | {"eccentric": "2 kg"})
    assert planned_rig(planned).mandrel == "none"
    assert planned_rig(SimpleNamespace(rig_keys=RIG)).mandrel == "M-01"
