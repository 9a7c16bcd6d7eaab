"""Teardowns of called procedures: where they stand, and when the run fails within the call."""

from __future__ import annotations

import threading

import pytest

from helpers_devices import FakeTester, Listener, record, run
from rigrunner.api.errors import DeviceLostError
from rigrunner.api.events import Outcome, StepEnded, StepStarted
from rigrunner.api.limits import ValueLimit
from rigrunner.api.member import Member
from rigrunner.engine import find_resume_point
from rigrunner.plan.actions import Phase, Plan, PlannedStep, Terms
from rigrunner.steps.measure import Measure
from rigrunner.steps.set_drives import SetDrive

# name, phase, calls; the names are set-points, so that a device can refuse any of them
STEPS = (
    (1, Phase.SETUP, ()),
    (10, Phase.MAIN, ("a",)),
    (11, Phase.MAIN, ("a", "b")),
    (12, Phase.TEARDOWN, ("a", "b")),
    (13, Phase.TEARDOWN, ("a", "b")),
    (14, Phase.MAIN, ("a",)),
    (15, Phase.TEARDOWN, ("a",)),
    (16, Phase.TEARDOWN, ("a",)),
    (20, Phase.MAIN, ()),
    (30, Phase.MAIN, ("c",)),
    (31, Phase.TEARDOWN, ("c",)),
    (40, Phase.TEARDOWN, ()),
    (41, Phase.TEARDOWN, ()),
)
PLAN = Plan(
    tuple(
        PlannedStep(str(name), phase, SetDrive("tester", "load", name, "N"), "", 0.0, calls=calls)
        for name, phase, calls in STEPS
    )
)


def steps_done(refused=None, stop_at=None):
    stop, listener = threading.Event(), Listener()

    def before(call):
        if call == f"set load {refused}":
            raise DeviceLostError("cable")
        if call == f"set load {stop_at}":
            stop.set()

    summary = run(FakeTester(before=before), PLAN, critical=[listener], stop=stop)
    return summary, [int(event.step) for event in listener.of(StepEnded)]


def test_without_a_failure_every_step_is_done_once_in_order():
    summary, done = steps_done()

    assert summary.outcome is Outcome.COMPLETED
    assert done == [name for name, _, _ in STEPS]


@pytest.mark.parametrize(
    ("refused", "followed_by"),
    [
        (1, [40, 41]),
        (10, [15, 16, 40, 41]),
        (11, [12, 13, 15, 16, 40, 41]),
        (12, [13, 15, 16, 40, 41]),
        (13, [15, 16, 40, 41]),
        (14, [15, 16, 40, 41]),
        (15, [16, 40, 41]),
        (16, [40, 41]),
        (20, [40, 41]),
        (30, [31, 40, 41]),
        (31, [40, 41]),
        (40, [41]),
        (41, []),
    ],
)
def test_after_a_failure_the_teardowns_of_all_calls_that_were_entered_are_done(
    refused, followed_by
):
    summary, done = steps_done(refused=refused)

    assert summary.outcome is Outcome.ERROR
    assert done[done.index(refused) + 1 :] == followed_by


@pytest.mark.parametrize(
    ("stop_at", "followed_by"),
    [
        (1, [40, 41]),
        (11, [12, 13, 15, 16, 40, 41]),
        (12, [13, 15, 16, 40, 41]),
        (16, [40, 41]),
        (20, [40, 41]),
    ],
)
def test_a_stop_request_is_obeyed_after_the_teardown_that_is_under_way(stop_at, followed_by):
    summary, done = steps_done(stop_at=stop_at)

    assert summary.outcome is Outcome.ABORTED
    assert done[done.index(stop_at) + 1 :] == followed_by


def test_a_value_out_of_limits_in_the_teardown_of_a_call_stops_the_run():
    """In the teardown of the run itself there is nothing left to stop."""
    load = Measure("table", (Member("tester", "load"),), 0.0, {}, {"tester.load": "N"})
    strict = Terms(limits=(ValueLimit("tester.load", maximum=5.0, unit="N"),))  # it reads 1000 N
    plan = Plan((
        PlannedStep("in", Phase.MAIN, SetDrive("tester", "load", 1.0, "N"), "", 0.0, calls=("a",)),
        PlannedStep("out", Phase.TEARDOWN, load, "", 0.0, strict, calls=("a",)),
        PlannedStep("rest", Phase.MAIN, SetDrive("tester", "load", 2.0, "N"), "", 0.0),
    ))  # fmt: skip
    device = FakeTester()
    summary = run(device, plan)

    assert summary.outcome is Outcome.STOPPED_AT_LIMIT
    assert summary.reason == "tester.load is 1000 N (limit: 5 N or less)"
    assert "set load 2" not in device.calls


def test_a_failure_while_a_run_is_taken_up_inside_a_call_is_followed_by_its_teardown():
    plan = Plan((
        PlannedStep("in", Phase.MAIN, SetDrive("tester", "load", 1.0, "N"), "", 0.0, calls=("a",)),
        PlannedStep("record", Phase.MAIN, record("001"), "", 0.0, calls=("a",)),
        PlannedStep(
            "out", Phase.TEARDOWN, SetDrive("tester", "load", 2.0, "N"), "", 0.0, calls=("a",)
        ),
        PlannedStep("last", Phase.TEARDOWN, SetDrive("tester", "load", 0.0, "N"), "", 0.0),
    ))  # fmt: skip
    first, second = Listener(), Listener()
    run(FakeTester(), plan, critical=[first])
    at = first.events.index(first.of(StepStarted)[1])
    resume_at = find_resume_point(plan.steps, first.events[: at + 1], "Ada")
    assert (resume_at.start, resume_at.before) == (1, (0,))

    def refuse(call):
        if call == "set load 1":
            raise DeviceLostError("cable")

    run(FakeTester(before=refuse), plan, critical=[second], resume_at=resume_at)

    assert [event.step for event in second.of(StepEnded)] == ["in", "out", "last"]
