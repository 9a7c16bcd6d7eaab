"""Where a run goes on that was broken off, by the events that it left."""

from __future__ import annotations

from dataclasses import replace

import pytest

from helpers_devices import MAIN, SETUP, FakeTester, Listener, plan_of, record, run
from helpers_pausing import decided, pausing_run, sweep
from rigrunner.api.errors import DataError, DeviceLostError
from rigrunner.api.events import RESUME_RUN, Intervention, Outcome, StepEnded, StepStarted
from rigrunner.engine import Choice, find_seam, streams_before
from rigrunner.plan.actions import Terms, Zero

SECOND = "main[0].sweep[1]"


def until(plan, path, *, ended=False):
    """Return the events of a whole run up to the begin, or the end, of one of its steps."""
    listener = Listener()
    run(FakeTester(), plan, guarded=[listener])
    kind = StepEnded if ended else StepStarted
    at = next(
        number
        for number, event in enumerate(listener.events)
        if isinstance(event, kind) and event.step == path
    )
    return listener.events[: at + 1]


def seam_at(plan, path, *, ended=False):
    return find_seam(plan.steps, until(plan, path, ended=ended), "Ada")


@pytest.mark.parametrize(
    ("broken", "ended", "start"),
    [
        (f"{SECOND}.setdrive", False, 3),
        (f"{SECOND}.record", False, 3),
        (f"{SECOND}.settle", True, 3),
        (f"{SECOND}.record", True, 6),
    ],
)
def test_a_set_point_that_was_broken_off_is_begun_anew(broken, ended, start):
    seam = seam_at(sweep(), broken, ended=ended)
    assert seam.start == start
    assert seam.before == ()


def test_setup_zero_and_drives_are_brought_back():
    plan = plan_of()
    seam = seam_at(plan, "main[5]")
    assert plan.steps[seam.start].action is MAIN[5]
    again = [plan.steps[index].action for index in seam.before]
    asked = SETUP[1]
    assert asked not in again  # it was answered, and a run has one answer
    assert again == [SETUP[0], SETUP[2], SETUP[3], MAIN[0], MAIN[4]]


def test_a_zero_within_the_run_is_taken_again_where_the_drives_stood():
    zero = Zero("tester", "torque", "N·m", within=0.05, duration_s=0.2)
    plan = plan_of((), (MAIN[0], zero, MAIN[1], record("a"), MAIN[4], record("b")))
    seam = seam_at(plan, "main[5]")
    assert [plan.steps[index].action for index in seam.before] == [MAIN[0], zero, MAIN[4]]


def unrepeatable(plan, path):
    steps = [
        replace(step, terms=Terms(repeatable=False)) if step.path == path else step
        for step in plan.steps
    ]
    return replace(plan, steps=tuple(steps))


def test_what_must_not_be_done_twice_is_kept_or_ends_the_matter():
    plan = unrepeatable(plan_of(), "setup[3]")
    assert 3 not in seam_at(plan, "main[3]").before
    with pytest.raises(DataError, match=r"setup\[3\] was broken off, and must not be done twice"):
        seam_at(plan, "setup[3]")


def test_a_drive_that_must_not_be_led_twice_is_not_taken_to_stand_where_it_stood():
    kept = unrepeatable(plan_of(), "main[0]")
    refused = r"main\[0\] must not be done twice, and what follows needs the drive where it left it"
    with pytest.raises(DataError, match=refused):
        seam_at(kept, "main[5]")
    of_the_zero = unrepeatable(plan_of(), "setup[2]")
    with pytest.raises(DataError, match=r"setup\[2\] must not be done twice"):
        seam_at(of_the_zero, "main[5]")
    led_anew = unrepeatable(plan_of(), "main[1]")  # the frequency, which main[4] sets again
    assert 1 not in seam_at(led_anew, "main[5]").before
    assert seam_at(unrepeatable(plan_of(), "main[0]"), "main[5]", ended=True).before == ()


def test_a_completed_step_that_must_not_be_redone_keeps_its_point_from_being_redone():
    plan = unrepeatable(sweep(), f"{SECOND}.settle")
    assert seam_at(plan, f"{SECOND}.record").start == 5


def test_skipped_and_repeated_points_are_gone_on_with_as_was_decided():
    _, listener, _, _ = pausing_run(f"{SECOND}.record", decided(Choice.SKIP, "too hot"))
    at = next(i for i, e in enumerate(listener.events) if getattr(e, "action", "") == "skip")
    seam = find_seam(sweep().steps, listener.events[: at + 1], "Ada")
    assert seam.start == 6
    assert seam.passed_over == (f"{SECOND}: skipped by Ada: too hot",)
    _, listener, _, _ = pausing_run(f"{SECOND}.record", decided(Choice.REPEAT))
    at = next(i for i, e in enumerate(listener.events) if getattr(e, "action", "") == "repeat")
    assert find_seam(sweep().steps, listener.events[: at + 1], "Ada").start == 3


def test_the_streams_behind_the_seam_are_counted_at_their_set_points():
    plan = plan_of()
    streams = streams_before(plan.steps, seam_at(plan, "main[5]"))
    assert streams == {"tester": [{"load": 1000.0, "frequency": 10.0}]}


def resumed(plan, events, device=None, **known):
    listener, device = Listener(), device or FakeTester()
    seam = find_seam(plan.steps, events, "Ada", "as it was")
    return run(device, plan, guarded=[listener], seam=seam, **known), listener, device


def test_a_run_that_is_taken_up_does_the_rest_and_says_so():
    plan = plan_of()
    before = until(plan, "main[5]")
    summary, listener, device = resumed(plan, before)
    assert summary.outcome is Outcome.COMPLETED
    (seam,) = listener.of(Intervention)
    assert (seam.action, seam.by, seam.subject) == (RESUME_RUN, "Ada", "as it was")
    assert [e.recording for e in listener.of(StepEnded) if e.recording] == ["002_20Hz_try2"]
    assert listener.events[0].seq == before[-1].seq + 1
    assert device.drives_at == {"load": 0.0, "frequency": 0.0}


def test_a_failure_while_it_is_taken_up_is_torn_down_and_made_safe():
    def lose(call):
        if call == "stream":
            raise DeviceLostError("gone")

    plan = plan_of()
    summary, listener, device = resumed(plan, until(plan, "main[5]"), FakeTester(before=lose))
    assert summary.outcome is Outcome.ERROR
    assert "gone" in summary.reason
    torn_down = [e.step for e in listener.of(StepEnded) if e.step.startswith("teardown")]
    assert torn_down == ["teardown[0]", "teardown[1]"]
    assert device.drives_at == {"load": 0.0, "frequency": 0.0}


def test_where_all_is_measured_only_the_teardown_is_left():
    plan = plan_of()
    summary, listener, _ = resumed(plan, until(plan, "main[5]", ended=True))
    assert summary.outcome is Outcome.COMPLETED
    assert [e.step for e in listener.of(StepEnded)] == ["teardown[0]", "teardown[1]"]
