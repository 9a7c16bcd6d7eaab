from __future__ import annotations

import threading
from collections import Counter

import numpy as np
import pytest

from rigrunner.api.errors import AbortedError
from rigrunner.jobs import InProcess, Processes
from rigrunner_bearings.compensations.checks import BUILD_UP
from rigrunner_bearings.compensations.checks import LIMITS as METHOD_LIMITS
from rigrunner_bearings.study.bench import NATURAL, nested
from rigrunner_bearings.study.breaks import BREAKS, REFUSED
from rigrunner_bearings.study.case import Case
from rigrunner_bearings.study.case_runner import CaseRunner
from rigrunner_bearings.study.diagnostics import Finding, cases, examine, run_diagnostics, tally
from rigrunner_bearings.study.diagnostics_rigs import POPULATIONS, healthy
from rigrunner_bearings.study.diagnostics_table import printed, study_document
from rigrunner_bearings.study.share import Share
from rigrunner_bearings.study.tables import markdown
from rigrunner_bearings.study.tools import primary_alone
from rigrunner_bearings.torque.checks import LIMITS
from rigrunner_bearings.torque.one_setup import LIMITS as SETUP_LIMITS
from rigrunner_bearings.torque.settings import SwingTorque

SIM, ODE = "swing_tester_sim", "swing_tester_ode"
NAMES = {limit.name for limit in (*LIMITS, *SETUP_LIMITS, *METHOD_LIMITS)}
SKIPPED = {BUILD_UP.name}
"""Not made if the station states the support friction under load, as in the study."""
FAULTS = {fault.name: fault for fault in BREAKS}


def finding(fault, *failed, simulator=SIM, number=0, error_nm=None):
    return Finding(Case(simulator, fault, 1, number), failed, ("stroke", "cycles"), error_nm)


@pytest.mark.parametrize(
    ("hits", "of", "low", "high"),
    [
        (0, 300, 0.0, 1 - 0.025 ** (1 / 300)),
        (300, 300, 0.025 ** (1 / 300), 1.0),
        (5, 100, 0.0164, 0.1128),
    ],
)
def test_interval_is_that_of_clopper_and_pearson(hits, of, low, high):
    assert Share(hits, of).interval == pytest.approx((low, high), abs=5e-5)


def test_alarms_are_counted_by_check_and_simulator():
    study = tally([finding("", "stroke"), finding(""), finding("", simulator=ODE)])
    assert study.healthy == 3
    assert study.alarms["stroke"] == {SIM: Share(1, 2), ODE: Share(0, 1)}
    assert study.alarms["cycles"][SIM] == Share(0, 2)


def test_break_is_missed_if_neither_flagged_nor_refused():
    rigs = [
        finding("few cycles", "cycles"),
        finding("few cycles", REFUSED, "stroke"),
        finding("few cycles", "stroke"),
    ]
    (row,) = tally(rigs).breaks
    assert row.missed == Share(1, 3)
    assert row.others == Counter({"stroke": 2, REFUSED: 1})


def test_undetectable_break_has_error_but_no_rate():
    fault = "support friction grows with load"
    (row,) = tally([finding(fault, error_nm=0.03), finding(fault, error_nm=-0.04)]).breaks
    assert row.missed is None
    assert row.error.rms_nm == pytest.approx(np.sqrt((0.03**2 + 0.04**2) / 2))
    assert row.error.largest_nm == 0.04


@pytest.mark.parametrize("fault", BREAKS, ids=lambda fault: fault.name)
def test_every_break_names_its_check_or_why_none(fault):
    assert bool(fault.seen_by) is not bool(fault.unseen)
    assert fault.seen_by in NAMES | {REFUSED, ""}


@pytest.mark.parametrize("fault", BREAKS, ids=lambda fault: fault.name)
def test_every_break_changes_the_rig(fault):
    rng = np.random.default_rng(5)
    rig = healthy(fault.simulators[-1], 1, rng)
    assert fault.apply(rig, rng) != rig


@pytest.mark.parametrize("simulator", POPULATIONS)
def test_settings_are_nested_as_in_a_station(simulator):
    rig = healthy(simulator, 7, np.random.default_rng(1))
    settings = nested(rig.no_load, rig.seed)
    branch, _, name = NATURAL[simulator].partition(".")
    assert settings["seed"] == 7
    assert settings[branch][name].endswith(" Hz")
    assert abs(float(settings[branch][name].removesuffix(" Hz")) / rig.reference_hz - 1) < 0.021


def test_cases_use_both_simulators_equally():
    all_cases = list(cases(3, 2, 9))
    assert Counter(case.simulator for case in all_cases if not case.fault) == {SIM: 3, ODE: 3}
    broken = Counter(case.fault for case in all_cases if case.fault)
    assert broken == dict.fromkeys(FAULTS, 2)
    assert len(set(all_cases)) == len(all_cases)


@pytest.mark.parametrize("simulator", POPULATIONS)
def test_broken_rig_is_flagged_reproducibly(simulator):
    case = Case(simulator, "clipping", 3, 0)
    result = examine(case)
    assert "clipping" in result.failed
    assert result == examine(case)


def test_healthy_rig_is_measured_right_without_alarm():
    result = examine(Case(SIM, "", 3, 0))
    assert result.failed == ()
    assert abs(result.error_nm) < 0.02
    assert set(result.performed) >= NAMES - SKIPPED


def test_too_few_cycles_are_refused():
    assert examine(Case(SIM, "too few cycles", 3, 0)).failed == (REFUSED,)


@pytest.mark.thorough
def test_two_processes_give_findings_of_one():
    all_cases = [Case(SIM, "too few cycles", 3, number) for number in range(3)]
    first, second = (
        CaseRunner(workers, threading.Event(), lambda _, __: None).findings(
            "diagnostics", examine, Finding, all_cases
        )
        for workers in (InProcess(), Processes(2))
    )
    assert first == second


def test_study_can_be_stopped():
    stop, done = threading.Event(), []

    def progress(count, of):
        done.append((count, of))
        if count:
            stop.set()

    runner = CaseRunner(InProcess(), stop, progress)
    with pytest.raises(AbortedError, match="stopped after 1 of 48 rigs"):
        run_diagnostics(healthy_rigs=1, broken_rigs=2, seed=1, runner=runner)
    total = 2 + 2 * len(BREAKS)
    assert done == [(0, total), (1, total)]


def test_tables_and_document_agree():
    rigs = [finding(""), finding("", simulator=ODE), finding("other eccentric", "stroke")]
    rigs += [finding("few cycles"), finding("few cycles", "cycles")]
    study = tally(rigs)
    assert "| few cycles | 5 to 9 | cycles | 1/2 (1.3-98.7 %) | - | - |" in markdown(printed(study))
    _, row = study_document(study)["breaks"]
    assert row["missed"]["hits"] == 1
    assert row["missed"]["interval_95"] == pytest.approx([0.0126, 0.9874], abs=1e-4)


def test_primary_method_of_study_is_chosen_by_label():
    methods = [{"energy": {}, "as": "work"}, "template_inverse"]
    spec = SwingTorque.model_validate({"compensations": methods, "primary": "work"})
    assert [method.name for method in primary_alone(spec).compensations] == ["energy"]
