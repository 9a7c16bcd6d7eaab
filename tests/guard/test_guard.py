"""No number of a shipped procedure or of a faulty rig moves without a commit that says why."""

from __future__ import annotations

import json

import pytest

from guard.numbers import moved
from guard.rigs import SEEDS
from guard.runs import RECORDED, SHIPPED, faulty_rig, shipped
from helpers_thorough import first

AGAIN = "meant so? PYTHONPATH=tests python -m guard, in a commit of its own that says why"
QUICKEST = sorted(SHIPPED, key=["support_friction", "gauge_rr"].count)
"""These two take as long as all others."""
recorded = json.loads(RECORDED.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", first(4, QUICKEST))
def test_a_shipped_procedure_finds_what_it_found(tmp_path, name):
    assert moved(recorded[name], shipped(name, tmp_path)) == [], AGAIN


@pytest.mark.parametrize("seed", first(1, SEEDS))
def test_a_faulty_rig_gives_what_it_gave(tmp_path, seed):
    assert moved(recorded[str(seed)], faulty_rig(seed, tmp_path)) == [], AGAIN


def test_a_number_that_moved_is_told():
    before = {"torque": 0.7, "torque U": 0.01, "verdict": "pass", "gone": 1.0}
    now = {"torque": 0.7 + 2e-8, "torque U": 0.01, "verdict": "fail", "new": 2.0}
    assert moved(before, now) == [
        "gone: gone, was 1.0",
        "new: new, is 2.0",
        "torque: 0.7 -> 0.70000002",
        "verdict: 'pass' -> 'fail'",
    ]
    assert moved(before, before | {"torque": 0.7 + 0.9e-8}) == []
