"""The study of faults: which errors count as silent, and that its cases match their names."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from rigrunner.api.devices import DeviceContext
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner_bearings.study.case import Case
from rigrunner_bearings.study.fault_kinds import FAULTS, UNSEEN
from rigrunner_bearings.study.fault_table import fault_rows, printed, study_document, summary
from rigrunner_bearings.study.faults import (
    ANALYSIS,
    CRASH,
    RECORDING,
    Finding,
    cases,
    examine,
    tally,
)
from rigrunner_bearings.study.share import Share
from rigrunner_bearings.study.tables import markdown

pytestmark = pytest.mark.figures

SIM = "swing_tester_sim"


def finding(fault, *answers, ratio=None, worst=None):
    return Finding(Case(SIM, fault, 1, 0), answers, "somewhere", ratio, worst)


def test_flagged_or_refused_case_is_not_silent():
    study = tally(
        [
            finding("torque stuck", "spikes", ratio=9.0, worst=9.0),
            finding("torque stuck", RECORDING),
            finding("torque stuck", ANALYSIS),
            finding("torque stuck", ratio=-0.4, worst=0.9),
            finding("torque stuck", ratio=-1.4, worst=1.9),
            finding("torque stuck", ratio=-2.4, worst=7.0),
            finding("", ratio=0.1, worst=0.2),
            finding("", "range", ratio=0.1, worst=0.2),
            finding("torque sensitivity", ratio=5.0, worst=5.0),
            finding("time back", CRASH),
        ]
    )
    row, crashed = study.rows
    assert (crashed.flagged_cases, crashed.silent.count) == (0, 0)
    assert [item.case.fault for item in study.crashed] == ["time back"]
    assert "time back 0 on swing_tester_sim, somewhere: crashed" in markdown(printed(study))
    assert (row.cases, row.recording_failed, row.refused, row.flagged_cases) == (6, 1, 1, 1)
    assert (study.silent.within, study.silent.beyond, study.silent.far_beyond) == (1, 1, 1)
    assert (study.silent.worst, study.silent.worst_point) == (2.4, 7.0)
    assert study.silent.share_beyond == Share(1, 3)
    assert [item.ratio for item in study.wrong] == [-2.4]
    assert (study.clean.count, study.clean_flagged) == (1, 1)
    assert study.unseen[0].silent.far_beyond == 1
    assert "1 of these with an error above twice" in summary(study)
    assert fault_rows(study)[0][2:6] == ["6", "1", "1", "1"]
    assert "| torque stuck |" in markdown(printed(study))
    assert study_document(study)["silent"]["above_twice"] == 1


def test_every_fault_is_drawn_equally_often_on_both_simulators():
    all_cases = list(cases(2 * len(FAULTS), 1))
    drawn = Counter(case.fault for case in all_cases)
    assert {drawn[fault.name] for fault in FAULTS} == {2}
    assert drawn[""] == len(FAULTS)
    assert len(set(all_cases)) == len(all_cases)
    by_fault = {(case.fault, case.simulator) for case in all_cases}
    assert len(by_fault) == 2 * (len(FAULTS) + len(UNSEEN) + 1)


@pytest.mark.parametrize("fault", [*FAULTS, *UNSEEN], ids=lambda fault: fault.name)
def test_plugin_accepts_whole_range_of_every_fault(fault, tmp_path):
    registry, rng = load_registry(), np.random.default_rng(2)
    context = DeviceContext("tester", SimulatedClock(), tmp_path)
    for _ in range(20):
        settings = {"plugin": SIM, "faults": [fault.draw(rng)]}
        registry.make_device("fault", settings, context)


@pytest.mark.parametrize(
    "name", ["not a number", "blocks dropped", "block twice", "wrong order", "gap in time"]
)
def test_faults_seen_by_engine_fail_the_recording(name):
    assert examine(Case(SIM, name, 1, 0)).answers == (RECORDING,)


@pytest.mark.thorough
def test_same_case_is_reproducible_and_clean_rig_measured_right():
    case = Case(SIM, "torque clipped", 1, 3)
    assert examine(case) == examine(case)
    clean = examine(Case(SIM, "", 1, 0))
    assert clean.answers == ()
    assert abs(clean.ratio) < 1
