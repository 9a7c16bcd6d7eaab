"""Pausing: where a run pauses, how it goes on, and what is recorded."""

from __future__ import annotations

from dataclasses import replace

import pytest

from helpers_devices import MAIN, FakeTester, Listener, measured, plan_of, record, run
from rigrunner.api.errors import DeviceLostError
from rigrunner.api.events import (
    Alarm,
    Intervention,
    Note,
    Outcome,
    Scanned,
    StepEnded,
    StepStarted,
)
from rigrunner.api.limits import ValueLimit
from rigrunner.api.member import Member
from rigrunner.api.units import unit
from rigrunner.engine import Choice, Interference
from rigrunner.engine.pausing import StopNow
from rigrunner.engine.points import point_at, settles_before
from rigrunner.plan.actions import Interlock, Phase, Plan, PlannedStep, Terms
from rigrunner.steps.measure import Measure
from rigrunner.steps.ramp import Ramp
from rigrunner.steps.scan import Scan
from rigrunner.steps.set_drives import SetDrive
from rigrunner.steps.settle import Settle
from rigrunner.steps.zero import Zero
from unit.engine.helpers_pausing import Patient, Person, decided, pausing_run, sweep

SECOND = "main[0].sweep[1]"
ZERO = Zero("tester", "torque", "N·m", within=0.05, duration_s=0.2)
SCAN = Scan(
    name="loads", role="tester", drive="load", values=(10.0, 20.0, 30.0),
    channels=(Member("tester", "torque"),), settle_s=0.1, setpoints={}, units={"tester.load": "N"},
)  # fmt: skip


def ended_steps(listener) -> list[tuple[str, bool]]:
    return [(event.step.removeprefix("main[0]."), event.ok) for event in listener.of(StepEnded)]


def recordings(listener) -> list[tuple[str, bool]]:
    return [(event.recording, event.ok) for event in listener.of(StepEnded) if event.recording]


@pytest.mark.parametrize("kind", ["setdrive", "settle", "record"])
def test_resumed_run_does_every_step(kind):
    summary, listener, person, device = pausing_run(f"{SECOND}.{kind}", decided(Choice.RESUME))
    assert (summary.outcome, summary.error) == (Outcome.COMPLETED, None)
    good = [name for name, ok in recordings(listener) if ok]
    assert len(good) == 3
    assert [event.action for event in listener.of(Intervention)] == ["pause", "resume"]
    assert [event.by for event in listener.of(Intervention)] == ["keyboard", "Ada"]
    assert person.seen[0].step == f"{SECOND}.{kind}"
    assert device.drives_at == {"load": 0.0, "frequency": 0.0}


def test_pause_interrupts_recording_which_is_repeated():
    summary, listener, _, _ = pausing_run(f"{SECOND}.record", decided(Choice.RESUME), inside=True)
    assert summary.outcome is Outcome.COMPLETED
    assert recordings(listener) == [
        ("001", True), ("002", False), ("002_try2", True), ("003", True),
    ]  # fmt: skip


def test_paused_device_settles_again_before_recording():
    _, listener, _, device = pausing_run(
        f"{SECOND}.record", decided(Choice.RESUME), device=Patient(), inside=True
    )
    assert ended_steps(listener)[3:9] == [
        ("sweep[1].setdrive", True),
        ("sweep[1].settle", True),
        ("sweep[1].record", False),
        ("sweep[1].settle", True),
        ("sweep[1].record", True),
        ("sweep[2].setdrive", True),
    ]
    assert [call for call in device.calls if call in {"pause", "resume"}] == ["pause", "resume"]


def test_device_that_cannot_pause_raises_alarm():
    _, listener, person, _ = pausing_run(f"{SECOND}.record", decided(Choice.RESUME))
    text = "tester cannot pause: frequency stays at 11 Hz"
    assert person.seen[0].moving == (text,)
    assert [(event.source, event.text) for event in listener.of(Alarm)] == [("pause", text)]


def test_device_at_rest_needs_no_pause():
    plan = replace(sweep(), steps=sweep().steps[1:])
    _, listener, person, _ = pausing_run(
        "main[0].sweep[0].settle", decided(Choice.RESUME), plan=plan
    )
    assert person.seen[0].moving == ()
    assert listener.of(Alarm) == []


def test_repeated_point_starts_at_set_point_and_keeps_attempts():
    plan = sweep()
    settled = replace(plan.steps[3], action=Settle(0.5), within=".after")
    plan = replace(plan, steps=(*plan.steps[:6], settled, *plan.steps[6:]))
    summary, listener, _, _ = pausing_run(f"{SECOND}.after", decided(Choice.REPEAT), plan=plan)
    assert summary.outcome is Outcome.COMPLETED
    assert recordings(listener) == [
        ("001", True), ("002", True), ("002_try2", True), ("003", True),
    ]  # fmt: skip
    steps = ended_steps(listener)
    assert steps[3:7] == [
        ("sweep[1].setdrive", True), ("sweep[1].settle", True), ("sweep[1].record", True),
        ("sweep[1].after", False),
    ]  # fmt: skip
    assert steps[7] == ("sweep[1].setdrive", True)
    (_, repeated) = listener.of(Intervention)
    assert (repeated.action, repeated.by, repeated.reason) == ("repeat", "Ada", SECOND)


def test_skipped_point_is_left_out_and_recorded():
    summary, listener, _, _ = pausing_run(f"{SECOND}.settle", decided(Choice.SKIP, "it squeals"))
    assert summary.outcome is Outcome.COMPLETED
    assert summary.passed_over == (f"{SECOND}: skipped by Ada: it squeals",)
    assert recordings(listener) == [("001", True), ("003", True)]
    assert listener.of(Intervention)[1].reason == f"{SECOND}: it squeals"


@pytest.mark.parametrize(
    ("skipped", "follows", "offered"),
    [
        (SetDrive("tester", "load", 500.0, "N"), (record("a", load=500.0),), False),
        (Ramp("tester", "load", 7.0, 500.0, "N", 1.0), (Settle(1.0), ZERO), False),
        (SCAN, (replace(SCAN, drive="frequency"),), False),
        (SCAN, (SetDrive("tester", "load", 9.0, "N"), record("a", load=9.0)), True),
        (SCAN, (SCAN, record("a", load=30.0)), True),
        (SCAN, (SetDrive("tester", "frequency", 9.0, "Hz"), Settle(1.0)), True),
        (SetDrive("tester", "load", 7.0, "N"), (record("a", load=7.0),), True),
    ],
)  # the load of the fake tester is at 7 N
def test_step_whose_set_point_is_needed_later_cannot_be_skipped(skipped, follows, offered):
    at, choices = "main[0]", [decided(Choice.SKIP, "no"), decided(Choice.ABORT)]
    plan = plan_of((), (skipped, *follows))
    summary, _, person, _ = pausing_run(at, *choices[not offered :], plan=plan)
    assert (Choice.SKIP in person.seen[0].choices) is offered
    assert (summary.outcome is Outcome.COMPLETED) is offered


@pytest.mark.parametrize(("settle_s", "points"), [(0.1, [0, 1, 2]), (0.0, [0, 0, 1, 2])])
def test_scan_interrupted_by_pause_starts_again(settle_s, points):
    """While it settles at its first point, or between that and the next one."""
    plan = plan_of((), (replace(SCAN, settle_s=settle_s), record("a", load=30.0)))
    summary, listener, _, device = pausing_run("main[0]", decided(Choice.RESUME), plan=plan)
    assert summary.outcome is Outcome.COMPLETED
    assert [event.point for event in listener.of(Scanned)] == points
    assert [row.setpoints["tester.load"] for row in measured(listener.events).rows] == [10, 20, 30]
    assert [c for c in device.calls if c.startswith("set load")][:4] == [
        "set load 10", "set load 10", "set load 20", "set load 30",
    ]  # fmt: skip
    assert summary.passed_over == ()


def test_pause_aborts_unrepeatable_scan():
    step = PlannedStep("main[0]", Phase.MAIN, SCAN, "", 1.0, Terms(repeatable=False))
    summary, listener, person, device = pausing_run("main[0]", plan=Plan((step,), ()))
    assert summary.outcome is Outcome.ABORTED
    assert "inside a step that cannot be repeated" in summary.reason
    assert (len(listener.of(Scanned)), person.seen) == (0, [])
    assert device.calls[-1] == "make_safe"


def test_unreadable_drive_during_pause_does_not_end_run():
    """A person can fix a cable while the run is paused."""

    def before(call):
        if call == "read_back load" and broken:
            raise DeviceLostError("cable")

    broken = [True]

    class Mender(Person):
        def decide(self, paused, watch):
            broken.clear()
            return super().decide(paused, watch)

    person, listener = Mender([decided(Choice.RESUME)]), Listener()
    person.pausing = True
    plan = plan_of((), (SetDrive("tester", "load", 5.0, "N"), record("a", load=5.0)))
    device = FakeTester(before=before)
    summary = run(device, plan, critical=[listener], pauses=person, clock=person.clock)
    assert summary.outcome is Outcome.COMPLETED
    assert Choice.SKIP not in person.seen[0].choices


def test_last_sweep_point_can_be_skipped_only_if_drive_is_set_again():
    plan = sweep()
    record_after = replace(plan.steps[-3], within="main[1]", points=(), action=record("after"))
    last = "main[0].sweep[2]"
    with_more = replace(plan, steps=(*plan.steps[:9], record_after, *plan.steps[9:]))
    for at, offered in ((f"{last}.setdrive", False), (f"{last}.settle", True)):
        _, _, person, _ = pausing_run(at, decided(Choice.RESUME), plan=with_more)
        assert (Choice.SKIP in person.seen[0].choices) is offered, at
    _, _, person, _ = pausing_run(f"{last}.setdrive", decided(Choice.RESUME))
    assert Choice.SKIP in person.seen[0].choices


def test_abort_during_pause_tears_down_and_makes_safe():
    summary, listener, _, device = pausing_run(f"{SECOND}.record", decided(Choice.ABORT))
    assert summary.outcome is Outcome.ABORTED
    assert listener.of(Intervention)[-1].by == "Ada"
    assert device.calls[-5:-1] == [
        "set frequency 0", "read_back frequency", "set load 0", "read_back load",
    ]  # fmt: skip
    assert device.calls[-1] == "make_safe"


def test_note_is_recorded_and_run_stays_paused():
    summary, listener, person, _ = pausing_run(
        f"{SECOND}.record", decided(Choice.NOTE, "oil on the mandrel"), decided(Choice.RESUME)
    )
    assert summary.outcome is Outcome.COMPLETED
    assert [event.text for event in listener.of(Note)] == ["Ada: oil on the mandrel"]
    assert len(person.seen) == 2


def test_pause_inside_unrepeatable_step_aborts():
    plan = sweep(repeatable=False)
    summary, listener, person, device = pausing_run(f"{SECOND}.record", plan=plan, inside=True)
    assert summary.outcome is Outcome.ABORTED
    assert "inside a step that cannot be repeated" in summary.reason
    assert person.seen == []
    assert recordings(listener) == [("001", True), ("002", False)]
    assert device.calls[-1] == "make_safe"


def test_point_with_unrepeatable_step_cannot_be_repeated():
    plan = sweep(repeatable=False)
    after = replace(plan.steps[4], within=".after")
    plan = replace(plan, steps=(*plan.steps[:6], after, *plan.steps[6:]))
    _, _, person, _ = pausing_run(
        f"{SECOND}.after", decided(Choice.REPEAT), decided(Choice.RESUME), plan=plan
    )
    assert Choice.REPEAT not in person.seen[0].choices
    assert len(person.seen) == 2  # what is not offered is not taken


def test_setup_cannot_be_skipped():
    plan = replace(sweep(), steps=tuple(
        replace(step, phase=step.phase.SETUP) if step.phase is step.phase.MAIN else step
        for step in sweep().steps
    ))  # fmt: skip
    _, _, person, _ = pausing_run(f"{SECOND}.settle", decided(Choice.RESUME), plan=plan)
    assert Choice.SKIP not in person.seen[0].choices


COLD = Interlock(
    name="cold", member=Member("tester", "load"), condition="below 5 N", shown=unit("N"),
    minimum=5.0, does="pause",
)  # fmt: skip


class Cooling(FakeTester):
    """Reads 0 N for `cold` readings, from the second point on."""

    cold = 10**9

    def read(self, channels):
        self.cold -= self.drives_at["frequency"] == 11.0
        low = self.drives_at["frequency"] == 11.0 and self.cold > 0
        return dict.fromkeys(channels, 0.0 if low else 9.0)


def test_run_paused_by_interlock_resumes_only_after_it_clears():
    device = Cooling()
    device.cold = 3
    plan = replace(sweep(), interlocks=(COLD,))
    summary, listener, person, _ = pausing_run(
        "nowhere", *[decided(Choice.RESUME)] * 9, plan=plan, device=device
    )
    assert summary.outcome is Outcome.COMPLETED
    assert len(person.seen) > 1
    assert person.seen[1].reason == "tester.load is 0 N, below 5 N; not cleared yet"
    assert listener.of(Intervention)[0].by == "interlock cold"


class ColdAtRest(Patient):
    """Reads 0 N for `cold` readings once it has been paused."""

    cold = 3
    at_rest = False

    def pause(self):
        super().pause()
        self.at_rest = True

    def resume(self):
        super().resume()
        self.at_rest = False

    def read(self, channels):
        self.cold -= self.at_rest
        return dict.fromkeys(channels, 0.0 if self.at_rest and self.cold > 0 else 9.0)


def test_run_does_not_resume_while_interlock_forbids_moving_drive():
    forbids = replace(COLD, does="forbid", forbids=(Member("tester", "frequency"),))
    plan, device = replace(sweep(), interlocks=(forbids,)), ColdAtRest()
    summary, _, person, _ = pausing_run(
        f"{SECOND}.settle", *[decided(Choice.RESUME)] * 9, plan=plan, device=device
    )
    assert summary.outcome is Outcome.COMPLETED
    assert person.seen[1].reason == "tester.load is 0 N, below 5 N; not cleared yet"
    assert device.cold <= 0  # it moved again only once that had cleared


def test_run_resumes_if_forbidden_drive_does_not_move():
    forbids = replace(COLD, does="forbid", forbids=(Member("tester", "load"),))
    plan, device = replace(sweep(), interlocks=(forbids,)), ColdAtRest()
    summary, _, person, _ = pausing_run(
        f"{SECOND}.settle", decided(Choice.RESUME), plan=plan, device=device
    )
    assert summary.outcome is Outcome.COMPLETED
    assert len(person.seen) == 1


def test_override_needs_permission_of_all_tripped_interlocks():
    strict = replace(COLD, name="strict")
    plan = replace(sweep(), interlocks=(replace(COLD, overridable=True), strict))
    _, _, person, _ = pausing_run("nowhere", decided(Choice.ABORT), plan=plan, device=Cooling())
    assert Choice.OVERRIDE not in person.seen[0].choices


def test_requested_pause_offers_no_override():
    plan = replace(sweep(), interlocks=(replace(COLD, overridable=True),))
    _, _, person, _ = pausing_run(f"{SECOND}.settle", decided(Choice.ABORT), plan=plan)
    assert Choice.OVERRIDE not in person.seen[0].choices


def test_stop_error_text_is_its_reason():
    assert str(StopNow("STOP at the panel", "panel")) == "STOP at the panel"


def test_override_needs_permission_of_station():
    plan = replace(sweep(), interlocks=(replace(COLD, overridable=True),))
    summary, listener, person, _ = pausing_run(
        "nowhere", decided(Choice.OVERRIDE, "sensor unplugged"), plan=plan, device=Cooling()
    )
    assert summary.outcome is Outcome.COMPLETED
    assert Choice.OVERRIDE in person.seen[0].choices
    (_, override) = listener.of(Intervention)
    assert (override.action, override.reason) == ("override", "sensor unplugged")
    strict = replace(sweep(), interlocks=(COLD,))
    summary, _, person, _ = pausing_run(
        "nowhere", decided(Choice.OVERRIDE, "no"), decided(Choice.ABORT), plan=strict,
        device=Cooling(),
    )  # fmt: skip
    assert summary.outcome is Outcome.ABORTED
    assert Choice.OVERRIDE not in person.seen[0].choices


def test_stop_now_skips_the_teardown_and_makes_safe():
    def stop(call):
        if call == "set frequency 11":
            raise StopNow

    device = FakeTester(before=stop)
    summary, listener, _, _ = pausing_run("nowhere", device=device)
    assert summary.outcome is Outcome.ABORTED
    assert device.calls[-2:] == ["set frequency 11", "make_safe"]
    assert summary.safe
    assert listener.of(Intervention)[0].by == "keyboard"


def test_outer_point_contains_inner_points():
    inner = [replace(step, points=("outer[0]", *step.points)) for step in sweep(2).steps[:6]]
    last = replace(inner[0], action=SetDrive("tester", "load", 0.0, "N"), points=("outer[0]",))
    steps = [*inner, last, replace(last, points=("outer[1]",))]
    assert point_at(steps, 1) == range(3)
    assert point_at(steps, 6) == range(7)
    assert point_at(steps, 7) == range(7, 8)
    assert point_at(inner[:3], 0) == range(3)  # the last step is not before the first


class Talkative(Person):
    """Has a new action to report each time."""

    count = 0

    def new_actions(self):
        self.count += 1
        return [Interference("take over", f"Ada {self.count}", subject="from Bob")]


def test_other_actions_of_persons_are_recorded_in_teardown_too():
    end = PlannedStep("teardown[0]", Phase.TEARDOWN, Settle(0.5), "", 0.5)
    listener, person = Listener(), Talkative([])
    plan = Plan((*sweep(1).steps, end))
    summary = run(FakeTester(), plan, critical=[listener], pauses=person, clock=person.clock)
    assert summary.outcome is Outcome.COMPLETED
    changes = listener.of(Intervention)
    assert [event.by for event in changes] == [f"Ada {n + 1}" for n in range(person.count)]
    assert {(event.action, event.subject) for event in changes} == {("take over", "from Bob")}
    started = next(event for event in listener.of(StepStarted) if event.step == end.path)
    assert any(event.seq > started.seq for event in changes)


def test_every_settle_since_last_set_is_repeated():
    plan = plan_of((), [Settle(9.0), MAIN[1], Settle(0.1), Settle(0.2), record("a")], ())
    assert settles_before(plan.steps, 4) == [2, 3]
    assert settles_before(plan.steps, 1) == []


def test_skipping_last_point_completes_run_without_teardown():
    plan = Plan(sweep(1).steps[:3])
    point = plan.steps[0].points[0]
    summary, _, _, _ = pausing_run(f"{point}.record", decided(Choice.SKIP, "worn"), plan=plan)
    assert summary.outcome is Outcome.COMPLETED
    assert summary.passed_over == (f"{point}: skipped by Ada: worn",)


def test_value_out_of_limits_in_teardown_of_skipped_call_stops_run():
    """The call is left, as by its end: its teardown counts as it does there."""
    point, within = ("main[0].repeat[0]",), ("main[0].repeat[0].call",)
    terms = Terms(limits=(ValueLimit("tester.load", maximum=5.0, unit="N"),))
    load, read = Member("tester", "load"), {"tester.load": "N"}
    parts = (
        (Phase.MAIN, Settle(0.5), Terms()),
        (Phase.TEARDOWN, Measure("end", (load,), 0.0, {}, read), terms),
    )
    steps = [
        PlannedStep(f".{n}", phase, action, "", 1.0, how, points=point, calls=within)
        for n, (phase, action, how) in enumerate(parts)
    ]
    after = PlannedStep("main[1]", Phase.MAIN, Settle(0.5), "", 1.0)
    summary, listener, _, _ = pausing_run(
        steps[0].path, decided(Choice.SKIP, "worn"), plan=Plan((*steps, after))
    )
    assert summary.outcome is Outcome.STOPPED_AT_LIMIT
    assert summary.reason.startswith("tester.load is 1000 N")
    assert after.path not in [event.step for event in listener.of(StepStarted)]


def test_actions_during_pause_are_recorded_before_it_ends():
    class Counting(Talkative):
        def decide(self, paused, watch):
            before = self.count
            decision = super().decide(paused, watch)
            counts.append(self.count - before)
            return decision

    counts: list[int] = []
    listener, person = Listener(), Counting([decided(Choice.RESUME)])

    def notice(event):
        if isinstance(event, StepStarted) and event.step == SECOND + ".settle":
            person.pausing = not person.seen

    listener.before = notice
    plan = sweep()
    run(FakeTester(), plan, critical=[listener], pauses=person, clock=person.clock)
    assert counts == [1]


def test_interlock_not_due_is_not_read_during_pause():
    seldom = replace(sweep(1), interlocks=(replace(COLD, every_s=1e6),))

    def readings(*choices):
        decisions = [decided(choice, "looked at it") for choice in choices]
        at = "main[0].sweep[0].settle"
        return pausing_run(at, *decisions, plan=seldom)[3].calls.count("read load")

    assert readings(*[Choice.NOTE] * 5, Choice.RESUME) == readings(Choice.RESUME)


class Watcher(Person):
    """Reads the channels when shown the rig, and whether a recording was running."""

    def show(self, rig):
        self.looks.append((rig.read("tester", ["torque"]), self.is_recording()))


def test_channels_are_shown_during_pause():
    class Looking(Watcher):
        def decide(self, paused, watch):
            before = len(self.looks)
            decision = super().decide(paused, watch)
            counts.append(len(self.looks) - before)
            return decision

    counts = []
    person = Looking([decided(Choice.RESUME)], pausing=True)
    person.looks, person.is_recording = [], bool
    run(FakeTester(), sweep(), pauses=person, clock=person.clock)
    assert counts == [1]


def test_channels_are_shown_during_waits_but_not_recordings():
    listener = Listener()

    def is_recording():
        started = [event for event in listener.of(StepStarted) if event.recording]
        return len(started) > len([event for event in listener.of(StepEnded) if event.recording])

    person = Watcher([])
    person.looks, person.is_recording = [], is_recording
    device, clock = FakeTester(), person.clock
    summary = run(device, sweep(), critical=[listener], pauses=person, clock=clock)
    assert summary.outcome is Outcome.COMPLETED
    assert len(person.looks) >= 3 * 5, "three times half a second of settling, every 0.1 s"
    assert not any(recording for _, recording in person.looks)
    assert all(Member("tester", "torque") in values for values, _ in person.looks)
