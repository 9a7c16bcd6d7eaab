"""Numbers of shipped procedures and of faulty rigs change only with a stated reason."""

from __future__ import annotations

import json

import pytest

from guard.numbers import differences
from guard.rigs import SEEDS
from guard.runs import RECORDED, SHIPPED, faulty_rig, shipped
from helpers_thorough import first

IF_INTENDED = "intended? PYTHONPATH=tests python -m guard, in a commit of its own that says why"
QUICKEST = sorted(SHIPPED, key=["support_friction", "gauge_rr"].count)
"""These two take as long as all others."""
recorded = json.loads(RECORDED.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", first(4, QUICKEST))
def test_shipped_procedure_gives_recorded_numbers(tmp_path, name):
    assert differences(recorded[name], shipped(name, tmp_path)) == [], IF_INTENDED


@pytest.mark.parametrize("seed", first(1, SEEDS))
def test_faulty_rig_gives_recorded_numbers(tmp_path, seed):
    assert differences(recorded[str(seed)], faulty_rig(seed, tmp_path)) == [], IF_INTENDED


def test_changed_numbers_are_reported():
    before = {"torque": 0.7, "torque U": 0.01, "verdict": "pass", "gone": 1.0}
    now = {"torque": 0.7 + 2e-8, "torque U": 0.01, "verdict": "fail", "new": 2.0}
    assert differences(before, now) == [
        "gone: gone, was 1.0",
        "new: new, is 2.0",
        "torque: 0.7 -> 0.70000002",
        "verdict: 'pass' -> 'fail'",
    ]
    assert differences(before, before | {"torque": 0.7 + 0.9e-8}) == []
