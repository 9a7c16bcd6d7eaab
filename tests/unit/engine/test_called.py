"""Teardowns of called procedures: where they stand, and when the run fails within the call."""

from __future__ import annotations

import threading

import pytest

from helpers_devices import FakeTester, Listener, run
from rigrunner.api.errors import DeviceLostError
from rigrunner.api.events import Outcome, StepEnded
from rigrunner.plan.actions import Phase, Plan, PlannedStep
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
    return summary, [int(one.step) for one in listener.of(StepEnded)]


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
