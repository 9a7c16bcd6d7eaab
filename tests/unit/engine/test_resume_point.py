"""Where an interrupted run resumes, by the events that it recorded."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import pytest

from helpers_devices import MAIN, SETUP, FakeTester, Listener, plan_of, record, run
from rigrunner.api.errors import DataError, DeviceLostError
from rigrunner.api.events import (
    RESUME_RUN,
    Intervention,
    Outcome,
    RunStarted,
    StepEnded,
    StepStarted,
)
from rigrunner.api.limits import ValueLimit
from rigrunner.api.member import Member
from rigrunner.api.units import unit
from rigrunner.engine import Choice, find_resume_point, streams_before
from rigrunner.plan.actions import Interlock, Terms
from rigrunner.steps.measure import Measure
from rigrunner.steps.set_drives import SetDrive
from rigrunner.steps.zero import Zero
from unit.engine.helpers_pausing import decided, pausing_run, sweep

SECOND = "main[0].sweep[1]"


def events_until(plan, path, *, ended=False):
    """Return the events of a run up to the start, or the end, of one of its steps."""
    listener = Listener()
    run(FakeTester(), plan, guarded=[listener])
    kind = StepEnded if ended else StepStarted
    at = next(
        number
        for number, event in enumerate(listener.events)
        if isinstance(event, kind) and event.step == path
    )
    return listener.events[: at + 1]


def resume_point_at(plan, path, *, ended=False):
    return find_resume_point(plan.steps, events_until(plan, path, ended=ended), "Ada")


@pytest.mark.parametrize(
    ("path", "ended", "start"),
    [
        (f"{SECOND}.setdrive", False, 3),
        (f"{SECOND}.record", False, 3),
        (f"{SECOND}.settle", True, 3),
        (f"{SECOND}.record", True, 6),
    ],
)
def test_interrupted_set_point_starts_again(path, ended, start):
    resume_at = resume_point_at(sweep(), path, ended=ended)
    assert resume_at.start == start
    assert resume_at.before == ()


def test_setup_zero_and_drives_are_restored():
    plan = plan_of()
    resume_at = resume_point_at(plan, "main[5]")
    assert plan.steps[resume_at.start].action is MAIN[5]
    repeated = [plan.steps[index].action for index in resume_at.before]
    question = SETUP[1]
    assert question not in repeated  # it was answered, and a run has one answer
    assert repeated == [SETUP[0], SETUP[2], SETUP[3], MAIN[0], MAIN[4]]


def test_zero_is_repeated_at_its_set_points():
    zero = Zero("tester", "torque", "N·m", within=0.05, duration_s=0.2)
    plan = plan_of((), (MAIN[0], zero, MAIN[1], record("a"), MAIN[4], record("b")))
    resume_at = resume_point_at(plan, "main[5]")
    assert [plan.steps[index].action for index in resume_at.before] == [MAIN[0], zero, MAIN[4]]


def test_zero_is_repeated_at_its_own_not_the_latest_set_points():
    zero = Zero("tester", "torque", "N·m", within=0.05, duration_s=0.2)
    unloaded = SetDrive("tester", "load", 10.0, "N")
    plan = plan_of((), (unloaded, zero, MAIN[0], record("a"), record("b")))
    resume_at = resume_point_at(plan, "main[4]")
    assert [plan.steps[index].action for index in resume_at.before] == [unloaded, zero, MAIN[0]]


def test_pause_waits_until_resumed_run_has_restored_its_state():
    plan = plan_of()
    summary, _, person, _ = pausing_run(
        "setup[3]", decided(Choice.RESUME), plan=plan, resume_at=resume_point_at(plan, "main[5]")
    )
    assert summary.outcome is Outcome.COMPLETED
    assert [paused.step for paused in person.seen] == ["main[5]"]


@pytest.mark.parametrize("after", ["connect", "stream"])  # before a step, and during one
def test_pausing_interlock_aborts_run_that_is_being_resumed(
    after,
):
    plan = plan_of()
    events = events_until(plan, "main[5]")
    hot = Interlock(
        name="hot",
        member=Member("tester", "load"),
        condition="above 900 N",
        shown=unit("N"),
        maximum=900.0,
        does="pause",
    )
    tester = FakeTester()
    tester.read = lambda names: dict.fromkeys(names, 1000.0 if after in tester.calls else 0.0)
    summary, listener, device = resume(replace(plan, interlocks=(hot,)), events, tester)
    assert ("stream" in device.calls) is (after == "stream")
    assert summary.outcome is Outcome.ABORTED
    assert summary.reason.endswith(", while the run was being resumed")
    aborts = [event for event in listener.of(Intervention) if event.action == "abort"]
    assert [event.by for event in aborts] == ["interlock hot"]
    assert not any(event.recording for event in listener.of(StepEnded))
    assert device.drives_at == {"load": 0.0, "frequency": 0.0}


def unrepeatable(plan, path):
    steps = [
        replace(step, terms=Terms(repeatable=False)) if step.path == path else step
        for step in plan.steps
    ]
    return replace(plan, steps=tuple(steps))


def test_unrepeatable_step_is_kept_or_prevents_resuming():
    plan = unrepeatable(plan_of(), "setup[3]")
    assert 3 not in resume_point_at(plan, "main[3]").before
    with pytest.raises(DataError, match=r"setup\[3\] was interrupted, and must not be done twice"):
        resume_point_at(plan, "setup[3]")


def test_unrepeatable_set_point_needed_later_prevents_resuming():
    unrepeatable_load = unrepeatable(plan_of(), "main[0]")
    message = r"main\[0\] must not be done twice, and what follows needs the drive where it left it"
    with pytest.raises(DataError, match=message):
        resume_point_at(unrepeatable_load, "main[5]")
    unrepeatable_setup = unrepeatable(plan_of(), "setup[2]")
    with pytest.raises(DataError, match=r"setup\[2\] must not be done twice"):
        resume_point_at(unrepeatable_setup, "main[5]")
    set_again = unrepeatable(plan_of(), "main[1]")  # the frequency, which main[4] sets again
    assert 1 not in resume_point_at(set_again, "main[5]").before
    assert resume_point_at(unrepeatable(plan_of(), "main[0]"), "main[5]", ended=True).before == ()


def test_completed_unrepeatable_step_prevents_repeating_its_point():
    plan = unrepeatable(sweep(), f"{SECOND}.settle")
    assert resume_point_at(plan, f"{SECOND}.record").start == 5


def test_left_out_step_does_not_prevent_repeating_its_point():
    plan = unrepeatable(sweep(), f"{SECOND}.settle")
    *events, ended = events_until(plan, f"{SECOND}.setdrive", ended=True)
    left_out = msgspec.structs.replace(ended, leaves=1)  # the settling, which was never done
    assert find_resume_point(plan.steps, [*events, left_out], "Ada").start == 3


def test_resume_follows_decision_to_skip_or_repeat():
    _, listener, _, _ = pausing_run(f"{SECOND}.record", decided(Choice.SKIP, "too hot"))
    at = next(i for i, e in enumerate(listener.events) if getattr(e, "action", "") == "skip")
    resume_at = find_resume_point(sweep().steps, listener.events[: at + 1], "Ada")
    assert resume_at.start == 6
    assert resume_at.passed_over == (f"{SECOND}: skipped by Ada: too hot",)
    _, listener, _, _ = pausing_run(f"{SECOND}.record", decided(Choice.REPEAT))
    at = next(i for i, e in enumerate(listener.events) if getattr(e, "action", "") == "repeat")
    assert find_resume_point(sweep().steps, listener.events[: at + 1], "Ada").start == 3


def test_streams_before_resume_point_have_their_set_points():
    plan = plan_of()
    streams = streams_before(plan.steps, resume_point_at(plan, "main[5]"))
    assert streams == {"tester": [{"load": 1000.0, "frequency": 10.0}]}


def resume(plan, events, device=None, **options):
    listener, device = Listener(), device or FakeTester()
    resume_at = find_resume_point(plan.steps, events, "Ada", "as it was")
    return run(device, plan, guarded=[listener], resume_at=resume_at, **options), listener, device


def test_resumed_run_does_remaining_steps_and_records_it():
    plan = plan_of()
    before = events_until(plan, "main[5]")
    summary, listener, device = resume(plan, before)
    assert summary.outcome is Outcome.COMPLETED
    (started,) = listener.of(RunStarted)
    # confirm, set load, zero, set load, set frequency; then record, and two teardown steps
    assert (started.run_id, started.steps, started.estimated_s) == ("test-run", 12, 8.0)
    (resume_at,) = listener.of(Intervention)
    assert (resume_at.action, resume_at.by, resume_at.subject) == (RESUME_RUN, "Ada", "as it was")
    assert [e.recording for e in listener.of(StepEnded) if e.recording] == ["002_20Hz_try2"]
    assert listener.events[0].seq == before[-1].seq + 1
    assert device.drives_at == {"load": 0.0, "frequency": 0.0}


def test_failure_while_resuming_tears_down_and_makes_safe():
    def lose(call):
        if call == "stream":
            raise DeviceLostError("gone")

    plan = plan_of()
    summary, listener, device = resume(plan, events_until(plan, "main[5]"), FakeTester(before=lose))
    assert summary.outcome is Outcome.ERROR
    assert "gone" in summary.reason
    torn_down = [e.step for e in listener.of(StepEnded) if e.step.startswith("teardown")]
    assert torn_down == ["teardown[0]", "teardown[1]"]
    assert device.drives_at == {"load": 0.0, "frequency": 0.0}


def test_only_teardown_remains_after_last_main_step():
    plan = plan_of()
    summary, listener, _ = resume(plan, events_until(plan, "main[5]", ended=True))
    assert summary.outcome is Outcome.COMPLETED
    assert [e.step for e in listener.of(StepEnded)] == ["teardown[0]", "teardown[1]"]


def lose_device(call):
    if call == "stream":
        raise DeviceLostError("cable")


def test_failed_unrepeatable_step_prevents_resuming():
    plan = unrepeatable(sweep(), f"{SECOND}.record")
    listener, device = Listener(), FakeTester()

    def fail(call):
        if len(listener.of(StepEnded)) == 5:
            lose_device(call)

    device.before = fail
    run(device, plan, guarded=[listener])
    at = next(n for n, e in enumerate(listener.events) if isinstance(e, StepEnded) and not e.ok)
    with pytest.raises(DataError, match=r"record was interrupted, and must not be done twice"):
        find_resume_point(plan.steps, listener.events[: at + 1], "Ada")
    with pytest.raises(DataError, match=r"record was interrupted, and must not be done twice"):
        resume_point_at(plan, f"{SECOND}.record")


def test_run_resumes_after_failed_step_that_continued():
    continues = Terms(continues=True)
    plan = plan_of((), (record("a"), MAIN[1], record("b")), ())
    steps = (replace(plan.steps[0], terms=continues), *plan.steps[1:])
    plan = replace(plan, steps=steps)
    listener = Listener()

    def fail(call):
        if not listener.of(StepEnded):
            lose_device(call)

    run(FakeTester(before=fail), plan, guarded=[listener])
    at = next(
        n for n, event in enumerate(listener.events)
        if isinstance(event, StepStarted) and event.step == "main[1]"
    )  # fmt: skip
    assert find_resume_point(plan.steps, listener.events[: at + 1], "Ada").start == 1


def test_streamed_mean_counts_as_stream_before_resume_point():
    mean = Measure(
        "table", (Member("tester", "torque"),), 0.2, {}, {"tester.torque": "N·m"}, 1000.0
    )
    read = replace(mean, sample_rate_hz=None)
    plan = plan_of((), (MAIN[0], mean, read, record("a")), ())
    assert streams_before(plan.steps, resume_point_at(plan, "main[3]")) == {
        "tester": [{"load": 1000.0}]
    }


def test_failed_unrepeatable_setup_step_is_not_done():
    plan = plan_of()
    once = replace(plan.steps[3], terms=Terms(continues=True, repeatable=False))
    plan = replace(plan, steps=(*plan.steps[:3], once, *plan.steps[4:]))
    listener = Listener()

    def fail(call):
        if len(listener.of(StepEnded)) == 3:
            lose_device(call)

    run(FakeTester(before=fail), plan, guarded=[listener])
    at = next(
        n for n, event in enumerate(listener.events)
        if isinstance(event, StepStarted) and event.step == "main[3]"
    )  # fmt: skip
    with pytest.raises(DataError, match=r"setup\[3\] was interrupted, and must not be done twice"):
        find_resume_point(plan.steps, listener.events[: at + 1], "Ada")


def test_settling_is_repeated_when_resuming_inside_set_point():
    point = "main[0].sweep[0]"
    plan = unrepeatable(sweep(1), f"{point}.settle")
    once = replace(plan.steps[1], within=".first")
    settle = replace(sweep(1).steps[1], within=".again")
    plan = replace(plan, steps=(plan.steps[0], once, settle, *plan.steps[2:]))
    events = events_until(plan, f"{point}.record")
    assert find_resume_point(plan.steps, events, "Ada").start == 3
    _, listener, _ = resume(plan, events)
    steps = [event.step for event in listener.of(StepStarted)]
    assert steps.index(f"{point}.again") < steps.index(f"{point}.record")


def test_resuming_finished_run_repeats_nothing():
    plan = replace(plan_of(), steps=sweep(1).steps[:3])
    events = events_until(plan, plan.steps[2].path, ended=True)
    assert find_resume_point(plan.steps, events, "Ada").start == 3
    summary, listener, _ = resume(plan, events)
    assert summary.outcome is Outcome.COMPLETED
    assert listener.of(StepStarted) == []


def test_drives_set_by_resumed_point_are_not_restored_before():
    """With two drives: one that is restored to the previous point would move twice."""
    plan = sweep(2)
    steps = []
    for step in plan.steps:
        if step.path.endswith(".setdrive"):
            load = replace(step.action, drive="load", unit="N")
            steps.append(replace(step, within=".load", action=load))
        steps.append(step)
    plan = replace(plan, steps=tuple(steps))
    drives = [step.action.drive for step in plan.steps[4:6] if isinstance(step.action, SetDrive)]
    assert drives == ["load", "frequency"]
    resume_at = resume_point_at(plan, f"{SECOND}.record")
    assert (resume_at.start, resume_at.before) == (4, ())


def test_value_out_of_limits_while_resuming_stops_run():
    plan = plan_of()
    limit = ValueLimit("tester.torque", maximum=-0.02, unit="mN·m")
    strict = [
        replace(step, terms=Terms(limits=(limit,))) if isinstance(step.action, Zero) else step
        for step in plan.steps
    ]
    events = events_until(plan, "main[5]")
    summary, listener, device = resume(replace(plan, steps=tuple(strict)), events)
    assert summary.outcome is Outcome.STOPPED_AT_LIMIT
    assert summary.reason.startswith("tester.torque is -9.9")
    assert [e.step for e in listener.of(StepStarted)] == [
        "setup[0]", "setup[2]", "setup[3]", "teardown[0]", "teardown[1]",
    ]  # fmt: skip
    assert device.drives_at == {"load": 0.0, "frequency": 0.0}


@pytest.mark.parametrize("choice", [Choice.SKIP, Choice.REPEAT])
def test_decision_after_last_step_leaves_nothing_to_do(choice):
    plan = replace(plan_of(), steps=sweep(1).steps[:3])
    events = events_until(plan, plan.steps[2].path, ended=True)
    fields = {"seq": len(events), "monotonic_s": 0.0, "utc": "", "by": "Ada", "reason": "too late"}
    late = Intervention(action=choice, **fields)
    assert find_resume_point(plan.steps, [*events, late], "Ada").start == 3


def test_cycles_continue_from_last_recorded_step():
    plan = sweep()
    events = [
        with_cycles(event, {"tester": 10.0 * number})
        for number, event in enumerate(events_until(plan, f"{SECOND}.record", ended=True))
    ]
    last = max(
        number
        for number, event in enumerate(events)
        if isinstance(event, (StepStarted, StepEnded)) and event.step.startswith("main")
    )
    assert find_resume_point(plan.steps, events, "Ada").cycles == {"tester": 10.0 * last}


def test_start_of_step_that_reads_nothing_does_not_reset_cycles():
    """It is recorded without a number of cycles; 10 Hz lasted for 0.5 s before."""
    assert resume_point_at(sweep(), f"{SECOND}.setdrive").cycles == {"tester": 5.0}


def test_cycles_of_setup_do_not_count():
    plan = plan_of()
    events = [with_cycles(event, {"tester": 7.0}) for event in events_until(plan, "setup[3]")]
    assert find_resume_point(plan.steps, events, "Ada").cycles == {}
    events = [
        *events[:-1],
        *(with_cycles(e, {"tester": 7.0}) for e in events_until(plan, "main[0]")),
    ]
    assert find_resume_point(plan.steps, events, "Ada").cycles == {"tester": 7.0}


def with_cycles(event, cycles):
    if not isinstance(event, (StepStarted, StepEnded)):
        return event
    return msgspec.structs.replace(event, cycles=cycles)
