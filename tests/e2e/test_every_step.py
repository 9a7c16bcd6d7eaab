"""At every step of both shipped procedures: after any fault the rig is safe, and on record."""

from __future__ import annotations

from collections import Counter

import pytest

from e2e.helpers_every_step import planned_moment, run_with_fault
from helpers_thorough import first
from rigrunner.api.calling import ThreadCaller
from rigrunner.api.events import InterlockTripped, MadeSafe, RunEnded, StepEnded, StepStarted
from rigrunner.plan.actions import Phase
from rigrunner.steps.record import Record
from rigrunner.steps.scan import Scan

PROCEDURES = ("no_load_inertia_sweep", "starting_torque_1000n")
FAULTS = {
    "exception": "error",
    "timeout": "error",
    "hang": "error",
    "interlock": "aborted",
    "terminate": "aborted",
    "interrupt": "aborted",
}
STANDSTILL = {"tester.frequency": 0.0, "tester.load": 0.0}
LATE = "'{}' was given up and has not come back: it may still move the drive"
MOVING = ("set frequency", "set load")
ORDER = ["tester.frequency", "tester.load", "tester"]


@pytest.fixture(scope="module", params=first(1, PROCEDURES))
def planned(request, tmp_path_factory):
    return planned_moment(tmp_path_factory.mktemp("moment"), request.param)


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(ThreadCaller, "grace_s", 0.01)


def events_of(events, kind):
    return [event for event in events if isinstance(event, kind)]


def assert_safe_on_record(events, times=1, may_hang=()) -> None:
    (ended,) = events_of(events, RunEnded)
    assert ended.read_back == STANDSTILL
    made = events_of(events, MadeSafe)
    assert [event.what for event in made] == ORDER * times
    problems = {problem for event in made for problem in event.problems}
    assert problems <= {LATE.format(call) for call in may_hang}
    assert made[-1].read_back == STANDSTILL


def assert_torn_down(events, plan) -> None:
    started = {event.step for event in events_of(events, StepStarted)}
    assert {step.path for step in plan.steps if step.phase is Phase.TEARDOWN} <= started


def outcome_of(events) -> str:
    return str(events_of(events, RunEnded)[0].outcome)


@pytest.mark.parametrize("fault", FAULTS)
def test_rig_is_safe_after_a_fault_at_every_step(planned, fault):
    """A fault in a plugin while an interlock reads trips the interlock: the run is aborted."""
    steps, ends = planned.plan.steps, Counter()
    for index, step in enumerate(steps):
        events = run_with_fault(planned, index, fault)
        assert_safe_on_record(events, may_hang=MOVING if fault == "hang" else ())
        assert_torn_down(events, planned.plan)
        if step.phase is Phase.TEARDOWN:
            continue
        ends[outcome_of(events)] += 1
        assert outcome_of(events) in {FAULTS[fault], "aborted"}, step.path
        assert fault != "interlock" or events_of(events, InterlockTripped), step.path
    assert ends[FAULTS[fault]] > 12
    assert len(steps) > 35


@pytest.mark.parametrize("name", first(1, PROCEDURES))
def test_interlock_makes_safe_before_the_teardown_at_every_step(tmp_path, name):
    planned = planned_moment(tmp_path, name, "make_safe")
    for index, step in enumerate(planned.plan.steps):
        ahead = step.phase is not Phase.TEARDOWN
        events = run_with_fault(planned, index, "interlock")
        assert_safe_on_record(events, times=2 if ahead else 1)
        if ahead:
            at = events.index(events_of(events, MadeSafe)[0])
            teardown = [
                event for event in events_of(events[:at], StepStarted) if "teardown" in event.step
            ]
            assert teardown == []


@pytest.mark.parametrize("fault", FAULTS)
def test_rig_is_safe_after_a_fault_within_a_scan(tmp_path, fault):
    scan = "{set: tester.load, over: [50 N, 99 N], channels: [tester.temperature], settle: 2 s}"
    planned = planned_moment(tmp_path, PROCEDURES[1], scan=scan)
    (index,) = [at for at, step in enumerate(planned.plan.steps) if isinstance(step.action, Scan)]
    events = run_with_fault(planned, index, fault, tmp_path / "runs")
    assert_safe_on_record(events, may_hang=MOVING if fault == "hang" else ())
    assert_torn_down(events, planned.plan)
    assert outcome_of(events) == FAULTS[fault]
    (ended,) = [event for event in events_of(events, StepEnded) if event.index == index]
    assert not ended.ok


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_is_recorded_in_the_run_file(planned, tmp_path, fault):
    recordings = [
        at for at, step in enumerate(planned.plan.steps) if isinstance(step.action, Record)
    ]
    events = run_with_fault(planned, recordings[1], fault, tmp_path / "runs")
    assert_safe_on_record(events)
    assert outcome_of(events) == FAULTS[fault]
