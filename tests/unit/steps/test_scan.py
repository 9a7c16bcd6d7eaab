"""A scan: point after point in one step, each on record, stopped and judged as steps are."""

from __future__ import annotations

import threading
from dataclasses import replace
from itertools import pairwise

import pytest

from helpers_devices import FakeTester, Listener, NthCall, measured, record, run
from rigrunner.api.errors import DataError, DeviceLostError, DeviceTimeoutError
from rigrunner.api.events import (
    Alarm,
    LimitMissed,
    Note,
    Outcome,
    Scanned,
    StepEnded,
    StepStarted,
)
from rigrunner.api.limits import ValueLimit
from rigrunner.api.member import Member
from rigrunner.api.quantity import parse_quantity
from rigrunner.api.units import unit
from rigrunner.bus import Bus
from rigrunner.clock import SimulatedClock
from rigrunner.engine import Choice, UnattendedAnswers, find_resume_point, run_plan, streams_before
from rigrunner.engine.resume_point import restoring_step
from rigrunner.plan.actions import Interlock, Phase, Plan, PlannedStep, Terms
from rigrunner.rig import Rig
from rigrunner.station.drive_rules import DriveRules
from rigrunner.station.limits import DriveLimits
from rigrunner.steps.scan import Scan
from rigrunner.steps.set_drives import SetDrive
from rigrunner.steps.settle import Settle
from unit.engine.helpers_pausing import Person, decided

LOADS = (10.0, 20.0, 30.0)
UNITS = {"tester.load": "N", "tester.torque": "N·m", "tester.frequency": "Hz"}
SCAN = Scan(
    name="friction",
    role="tester",
    drive="load",
    values=LOADS,
    channels=(Member("tester", "torque"),),
    settle_s=0.0,
    setpoints={"tester.frequency": 2.0},
    units=UNITS,
)


class Press(FakeTester):
    """Reads as torque a thousandth of the load that it is set to."""

    def read(self, channels):
        super().read(channels)
        return dict.fromkeys(channels, 0.001 * self.drives_at["load"])


def plan_of(*actions, interlocks=()):
    pairs = [action if isinstance(action, tuple) else (action, Terms()) for action in actions]
    steps = tuple(
        PlannedStep(f"main[{n}]", Phase.MAIN, action, "", 1.0, terms)
        for n, (action, terms) in enumerate(pairs)
    )
    return Plan(steps, tuple(interlocks))


def done(device, *actions, interlocks=(), **more):
    listener = Listener()
    return run(
        device, plan_of(*actions, interlocks=interlocks), critical=[listener], **more
    ), listener


def limited(high, marginal=0.0):
    limit = ValueLimit.between("tester.torque", None, parse_quantity(high), marginal)
    return replace(SCAN, limits=(limit,))


def rows(events):
    return [(event.point, dict(event.setpoints), dict(event.values)) for event in events]


def row(point, load):
    return point, {"tester.frequency": 2.0, "tester.load": load}, {"tester.torque": 1e-3 * load}


ALL = [row(point, load) for point, load in enumerate(LOADS)]


def test_each_point_is_set_read_back_read_and_on_record():
    device = Press()
    summary, listener = done(device, SCAN)
    assert summary.outcome is Outcome.COMPLETED
    assert rows(listener.of(Scanned)) == ALL
    assert {event.measurement for event in listener.of(Scanned)} == {"friction"}
    at = device.calls.index("set load 10")
    calls = [c for load in LOADS for c in (f"set load {load:g}", "read_back load", "read torque")]
    assert device.calls[at : at + 9] == calls
    (started,), (ended,) = listener.of(StepStarted), listener.of(StepEnded)
    assert (started.action, ended.action, ended.ok) == ("scan", "scan", True)
    order = [type(e) for e in listener.events if isinstance(e, (StepStarted, Scanned, StepEnded))]
    assert order == [StepStarted, Scanned, Scanned, Scanned, StepEnded]


def test_what_was_measured_has_units_and_the_time_of_its_point():
    _, listener = done(Press(), SCAN)
    table = measured(listener.events).rows
    assert [(row.name, dict(row.setpoints), dict(row.values)) for row in table] == [
        ("friction", setpoints, values) for _, setpoints, values in ALL
    ]
    assert table[0].units == {"tester.frequency": "Hz", "tester.load": "N", "tester.torque": "N·m"}
    assert [row.utc for row in table] == [event.utc for event in listener.of(Scanned)]


def test_it_waits_at_each_point():
    clock, times = SimulatedClock(), []

    def before(call):
        if call.startswith(("set load", "read ")):
            times.append((call, clock.monotonic_s()))

    done(Press(before=before), replace(SCAN, settle_s=0.25), clock=clock)
    scanned = [(call, at_s - times[0][1]) for call, at_s in times][:6]
    assert scanned == [
        ("set load 10", 0.0), ("read torque", pytest.approx(0.25)),
        ("set load 20", pytest.approx(0.25)), ("read torque", pytest.approx(0.5)),
        ("set load 30", pytest.approx(0.5)), ("read torque", pytest.approx(0.75)),
    ]  # fmt: skip


def test_a_value_out_of_limits_ends_it_and_is_its_last_row():
    device = Press()
    summary, listener = done(device, limited("0.015 N·m"))
    assert (summary.error, summary.outcome) == (None, Outcome.STOPPED_AT_LIMIT)
    where, limit = "at tester.load 20 N (point 2 of 3)", "(limit: 0.015 N·m or less)"
    assert summary.reason == f"{where}: tester.torque is 0.02 N·m {limit}"
    assert "set load 30" not in device.calls
    assert rows(listener.of(Scanned)) == ALL[:2]
    table = measured(listener.events).rows
    assert [[decision.passes for decision in row.decisions] for row in table] == [[True], [False]]
    (missed,) = listener.of(LimitMissed)
    assert missed.text == summary.reason


def test_a_scan_that_goes_on_after_its_limits_keeps_every_point():
    device = Press()
    summary, listener = done(device, replace(limited("0.015 N·m"), stops_at_limit=False))
    assert (summary.outcome, summary.reason) == (Outcome.COMPLETED, "")
    assert rows(listener.of(Scanned)) == ALL
    table = measured(listener.events).rows
    assert [decision.passes for row in table for decision in row.decisions] == [True, False, False]
    assert len(listener.of(LimitMissed)) == 2


def test_rows_of_a_scan_that_is_begun_anew_are_kept_beside():
    fault = NthCall(4, DeviceLostError("cable"), never=("connect", "make_safe"))
    _, listener = done(Press(before=fault), (SCAN, Terms(attempts=2)))
    attempts = measured(listener.events)
    assert (len(attempts.rows), len(attempts.superseded)) == (3, 1)
    assert attempts.superseded[0].utc == listener.of(Scanned)[0].utc


def test_a_marginal_value_is_noted_with_its_set_point():
    _, listener = done(Press(), limited("0.035 N·m", marginal=0.01))
    (note,) = listener.of(Note)
    assert note.text.startswith(
        "at tester.load 30 N (point 3 of 3): tester.torque is 0.03 N·m, marginal"
    )


def test_a_device_that_fails_is_named_with_the_point():
    fault = NthCall(4, DeviceLostError("cable"), never=("connect", "make_safe"))
    summary, listener = done(Press(before=fault), SCAN)
    assert summary.reason == "at tester.load 20 N (point 2 of 3): tester: cable"
    assert rows(listener.of(Scanned)) == ALL[:1]


def test_a_scan_that_is_tried_again_begins_anew_and_its_last_try_counts():
    fault = NthCall(4, DeviceLostError("cable"), never=("connect", "make_safe"))
    summary, listener = done(Press(before=fault), (SCAN, Terms(attempts=2)))
    assert summary.outcome is Outcome.COMPLETED
    assert rows(listener.of(Scanned)) == ALL[:1] + ALL
    assert [row.utc for row in measured(listener.events).rows] == [
        event.utc for event in listener.of(Scanned)[1:]
    ]
    assert [event.text for event in listener.of(Alarm)] == [
        "at tester.load 20 N (point 2 of 3): tester: cable; try 1 of 2"
    ]


def test_the_completed_attempt_counts_when_the_next_one_is_interrupted():
    _, listener = done(Press(), SCAN)
    again = [event for event in listener.events if isinstance(event, (StepStarted, Scanned))][:2]
    assert len(measured([*listener.events, *again]).rows) == len(LOADS)
    assert len(measured(again).rows) == 1


def test_a_stop_request_ends_it_between_two_points():
    stop = threading.Event()

    def before(call):
        if call == "set load 20":
            stop.set()

    device = Press(before=before)
    summary, listener = done(device, SCAN, stop=stop)
    assert summary.outcome is Outcome.ABORTED
    assert len(listener.of(Scanned)) == 2
    assert "set load 30" not in device.calls


def test_a_time_limit_holds_for_all_of_it():
    scan = replace(SCAN, settle_s=0.4), Terms(timeout_s=1.0)
    summary, listener = done(Press(), scan, clock=SimulatedClock())
    assert isinstance(summary.error, DeviceTimeoutError)
    assert len(listener.of(Scanned)) == 2


def test_no_point_is_begun_once_the_time_limit_is_over():
    """Each reading takes 0.6 s; nothing waits in between, which would look at the time as well."""
    clock = SimulatedClock()
    device = Press(before=lambda call: clock.sleep(0.6) if call.startswith("read t") else None)
    summary, listener = done(device, (SCAN, Terms(timeout_s=1.0)), clock=clock)
    assert isinstance(summary.error, DeviceTimeoutError)
    assert len(listener.of(Scanned)) == 2
    assert "set load 30" not in device.calls


def test_a_pause_is_taken_between_two_points():
    person = Person([decided(Choice.ABORT)])
    device, listener = Press(), Listener()

    def ask(event) -> None:
        person.pausing = isinstance(event, Scanned) and event.point == 1

    listener.before = ask
    summary = run(device, plan_of(SCAN), critical=[listener], pauses=person, clock=person.clock)
    assert summary.outcome is Outcome.ABORTED
    assert len(person.seen) == 1
    assert "set load 30" not in device.calls


def test_interlocks_are_read_before_each_point():
    overload = Interlock(
        name="overload", member=Member("tester", "torque"), condition="above 0.015 N·m",
        maximum=0.015, shown=unit("N·m"), every_s=1e6,
    )  # fmt: skip
    device = Press()
    summary, listener = done(device, SCAN, interlocks=[overload])
    assert "overload" in summary.reason or "above 0.015" in summary.reason
    assert len(listener.of(Scanned)) == 2
    assert "set load 30" not in device.calls


def test_channels_are_in_the_order_that_was_asked_for():
    scan = replace(SCAN, channels=(Member("tester", "torque"), Member("tester", "angle")))
    _, listener = done(Press(), scan)
    assert {tuple(event.values) for event in listener.of(Scanned)} == {scan.channels}


def test_a_run_that_goes_on_after_it_brings_the_drive_back_without_measuring_again():
    plan = plan_of(SCAN, SetDrive("tester", "frequency", 5.0, "Hz"), Settle(0.1), record("a"))
    listener = Listener()
    run(Press(), plan, critical=[listener])
    at = next(
        n for n, one in enumerate(listener.events)
        if isinstance(one, StepStarted) and one.step == "main[3]"
    )  # fmt: skip
    resume_at = find_resume_point(plan.steps, listener.events[: at + 1], "Ada")
    assert (resume_at.start, resume_at.before) == (3, (0, 1))
    back = restoring_step(plan.steps[0])
    assert back.action == SetDrive("tester", "load", 30.0, "N")
    assert back.text == "Set tester.load to 30 N, where the scan left it"
    device, more = Press(), Listener()
    run(device, plan, critical=[more], resume_at=resume_at)
    assert [c for c in device.calls if c.startswith("set load")] == ["set load 30"]
    assert not more.of(Scanned)
    assert len(measured([*listener.events[: at + 1], *more.events]).rows) == len(LOADS)
    assert streams_before(plan.steps, replace(resume_at, start=4)) == {
        "tester": [{"load": 30.0, "frequency": 5.0}]
    }


@pytest.mark.parametrize(("repeatable", "loads"), [(True, LOADS), (False, LOADS[-1:])])
def test_in_a_setup_it_is_done_once_more_as_setup_is(repeatable, loads):
    setup = PlannedStep("setup[0]", Phase.SETUP, SCAN, "", 1.0, Terms(repeatable=repeatable))
    plan = Plan((setup, PlannedStep("main[0]", Phase.MAIN, record("a"), "", 1.0)), ())
    listener = Listener()
    run(Press(), plan, critical=[listener])
    at = next(n for n, one in enumerate(listener.events) if getattr(one, "step", "") == "main[0]")
    resume_at = find_resume_point(plan.steps, listener.events[: at + 1], "Ada")
    device, more = Press(), Listener()
    run(device, plan, critical=[more], resume_at=resume_at)
    assert [c for c in device.calls if c.startswith("set load")] == [
        f"set load {load:g}" for load in loads
    ]
    table = measured([*listener.events[: at + 1], *more.events]).rows
    assert [row.setpoints["tester.load"] for row in table] == list(LOADS)


def test_one_that_must_not_be_done_twice_leaves_the_drive_where_it_was_and_is_not_begun_anew():
    once = (SCAN, Terms(repeatable=False))
    plan = plan_of(once, SetDrive("tester", "frequency", 5.0, "Hz"), record("a"))
    listener = Listener()
    run(Press(), plan, critical=[listener])
    steps = [n for n, one in enumerate(listener.events) if isinstance(one, StepStarted)]
    device, more = Press(), Listener()
    resume_at = find_resume_point(plan.steps, listener.events[: steps[2] + 1], "Ada")
    run(device, plan, critical=[more], resume_at=resume_at)
    assert [c for c in device.calls if c.startswith("set load")] == ["set load 30"]
    assert not more.of(Scanned)
    within = listener.events.index(listener.of(Scanned)[1])
    with pytest.raises(DataError, match=r"main\[0\] was interrupted, and must not be done twice"):
        find_resume_point(plan.steps, listener.events[: within + 1], "Ada")


def test_a_run_that_was_interrupted_within_it_begins_it_anew():
    plan = plan_of(SetDrive("tester", "frequency", 2.0, "Hz"), SCAN)
    listener = Listener()
    run(Press(), plan, critical=[listener])
    at = listener.events.index(listener.of(Scanned)[1])
    resume_at = find_resume_point(plan.steps, listener.events[: at + 1], "Ada")
    assert (resume_at.start, resume_at.before) == (1, (0,))
    more = Listener()
    run(Press(), plan, critical=[more], resume_at=resume_at)
    table = measured([*listener.events[: at + 1], *more.events]).rows
    assert [row.setpoints["tester.load"] for row in table] == list(LOADS)


def test_through_a_thread_it_is_the_same():
    device = Press(non_blocking=False)
    summary, listener = done(device, SCAN)
    assert summary.outcome is Outcome.COMPLETED
    assert rows(listener.of(Scanned)) == ALL
    assert threading.main_thread().name not in device.threads


def test_in_a_teardown_it_is_done_though_the_run_was_stopped():
    stop = threading.Event()
    stop.set()
    steps = (
        PlannedStep("main[0]", Phase.MAIN, SetDrive("tester", "load", 5.0, "N"), "", 1.0),
        PlannedStep("teardown[0]", Phase.TEARDOWN, SCAN, "", 1.0),
    )
    listener = Listener()
    summary = run(Press(), Plan(steps, ()), critical=[listener], stop=stop)
    assert summary.outcome is Outcome.ABORTED
    assert rows(listener.of(Scanned)) == ALL


def test_a_sink_that_cannot_keep_a_point_ends_the_run_and_no_further_point_is_begun():
    device, events = Press(), []

    def keep(event):
        if isinstance(event, Scanned):
            if event.point == 1:
                raise DataError("the disk is full")
            events.append(event)

    summary = run(device, plan_of((SCAN, Terms(attempts=3))), critical=[keep])
    assert summary.outcome is Outcome.ERROR
    assert "the disk is full" in summary.reason
    assert "set load 30" not in device.calls
    assert device.calls.count("set load 10") == 1  # it is no failure of the step, to be tried again
    assert len(events) == 1


def test_channels_of_two_devices_are_a_row():
    class Room:
        """A device that only reads."""

        non_blocking = True
        channels = (replace(FakeTester.channels[0], name="room", unit="K"),)
        drives = ()

        def connect(self, timeout_s):
            return FakeTester().connect(timeout_s)

        def make_safe(self):
            return {}

        def close(self):
            """Nothing is held."""

        def read(self, channels):
            return dict.fromkeys(channels, 296.0)

    scan = replace(
        SCAN,
        channels=(Member("room", "room"), Member("tester", "torque"), Member("tester", "load")),
    )
    listener, clock = Listener(), SimulatedClock()
    rig = Rig({"tester": Press(), "room": Room()}, clock)
    rig.connect()
    bus, never = Bus([listener]), threading.Event()
    run_plan(plan_of(scan), rig, bus, clock, UnattendedAnswers(), never, "two")
    assert [dict(event.values) for event in listener.of(Scanned)] == [
        {"room.room": 296.0, "tester.torque": 1e-3 * load, "tester.load": 1e-3 * load}
        for load in LOADS
    ]


def test_ctrl_c_within_a_scan_is_told_as_such():
    def interrupt(call):
        if call == "set load 20":
            raise KeyboardInterrupt

    summary, _ = done(FakeTester(before=interrupt), SCAN)
    assert summary.outcome is Outcome.ABORTED
    assert isinstance(summary.error, KeyboardInterrupt)


def test_a_drive_that_the_station_wants_slower_is_led_to_each_point():
    device, clock, listener = Press(), SimulatedClock(), Listener()
    rules = DriveRules({Member("tester", "load"): DriveLimits(rate="20 N/s")})
    rig = Rig({"tester": device}, clock, rules=rules)
    rig.connect()
    device.drives_at["load"] = 0.0
    bus, never = Bus([listener]), threading.Event()
    summary = run_plan(plan_of(SCAN), rig, bus, clock, UnattendedAnswers(), never, "led")
    assert summary.outcome is Outcome.COMPLETED
    assert rows(listener.of(Scanned)) == ALL
    loads = [float(call.split()[-1]) for call in device.calls if call.startswith("set load")]
    way = loads[: loads.index(LOADS[-1]) + 1]
    assert all(0.0 <= after - before < 2.5 for before, after in pairwise(way))  # 2 N in 0.1 s
