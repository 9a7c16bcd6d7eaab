"""A scan: several points in one step, each recorded; stopped and checked like any step."""

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
    """A tester whose torque is a thousandth of its load."""

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


def scan_run(device, *actions, interlocks=(), **more):
    listener = Listener()
    return run(
        device, plan_of(*actions, interlocks=interlocks), critical=[listener], **more
    ), listener


def scan_with_limit(high, marginal=0.0):
    limit = ValueLimit.between("tester.torque", None, parse_quantity(high), marginal)
    return replace(SCAN, limits=(limit,))


def rows(events):
    return [(event.point, dict(event.setpoints), dict(event.values)) for event in events]


def row(point, load):
    return point, {"tester.frequency": 2.0, "tester.load": load}, {"tester.torque": 1e-3 * load}


ALL = [row(point, load) for point, load in enumerate(LOADS)]


def test_each_point_is_set_read_back_read_and_recorded():
    device = Press()
    summary, listener = scan_run(device, SCAN)
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


def test_rows_have_units_and_the_time_of_their_point():
    _, listener = scan_run(Press(), SCAN)
    table = measured(listener.events).rows
    assert [(row.name, dict(row.setpoints), dict(row.values)) for row in table] == [
        ("friction", setpoints, values) for _, setpoints, values in ALL
    ]
    assert table[0].units == {"tester.frequency": "Hz", "tester.load": "N", "tester.torque": "N·m"}
    assert [row.utc for row in table] == [event.utc for event in listener.of(Scanned)]


def test_scan_settles_at_each_point():
    clock, times = SimulatedClock(), []

    def before(call):
        if call.startswith(("set load", "read ")):
            times.append((call, clock.monotonic_s()))

    scan_run(Press(before=before), replace(SCAN, settle_s=0.25), clock=clock)
    scanned = [(call, at_s - times[0][1]) for call, at_s in times][:6]
    assert scanned == [
        ("set load 10", 0.0), ("read torque", pytest.approx(0.25)),
        ("set load 20", pytest.approx(0.25)), ("read torque", pytest.approx(0.5)),
        ("set load 30", pytest.approx(0.5)), ("read torque", pytest.approx(0.75)),
    ]  # fmt: skip


def test_missed_limit_ends_the_scan_after_its_row():
    device = Press()
    summary, listener = scan_run(device, scan_with_limit("0.015 N·m"))
    assert (summary.error, summary.outcome) == (None, Outcome.STOPPED_AT_LIMIT)
    where, limit = "at tester.load 20 N (point 2 of 3)", "(limit: 0.015 N·m or less)"
    assert summary.reason == f"{where}: tester.torque is 0.02 N·m {limit}"
    assert "set load 30" not in device.calls
    assert rows(listener.of(Scanned)) == ALL[:2]
    table = measured(listener.events).rows
    assert [[decision.passes for decision in row.decisions] for row in table] == [[True], [False]]
    (missed,) = listener.of(LimitMissed)
    assert missed.text == summary.reason


def test_scan_that_continues_past_limits_keeps_every_point():
    device = Press()
    summary, listener = scan_run(
        device, replace(scan_with_limit("0.015 N·m"), stops_at_limit=False)
    )
    assert (summary.outcome, summary.reason) == (Outcome.COMPLETED, "")
    assert rows(listener.of(Scanned)) == ALL
    table = measured(listener.events).rows
    assert [decision.passes for row in table for decision in row.decisions] == [True, False, False]
    assert len(listener.of(LimitMissed)) == 2


def test_rows_of_a_repeated_scan_are_superseded():
    fault = NthCall(4, DeviceLostError("cable"), never=("connect", "make_safe"))
    _, listener = scan_run(Press(before=fault), (SCAN, Terms(attempts=2)))
    attempts = measured(listener.events)
    assert (len(attempts.rows), len(attempts.superseded)) == (3, 1)
    assert attempts.superseded[0].utc == listener.of(Scanned)[0].utc


def test_a_marginal_value_is_noted_with_its_set_point():
    _, listener = scan_run(Press(), scan_with_limit("0.035 N·m", marginal=0.01))
    (note,) = listener.of(Note)
    assert note.text.startswith(
        "at tester.load 30 N (point 3 of 3): tester.torque is 0.03 N·m, marginal"
    )


def test_failure_names_the_device_and_the_point():
    fault = NthCall(4, DeviceLostError("cable"), never=("connect", "make_safe"))
    summary, listener = scan_run(Press(before=fault), SCAN)
    assert summary.reason == "at tester.load 20 N (point 2 of 3): tester: cable"
    assert rows(listener.of(Scanned)) == ALL[:1]


def test_repeated_scan_starts_over_and_its_last_attempt_counts():
    fault = NthCall(4, DeviceLostError("cable"), never=("connect", "make_safe"))
    summary, listener = scan_run(Press(before=fault), (SCAN, Terms(attempts=2)))
    assert summary.outcome is Outcome.COMPLETED
    assert rows(listener.of(Scanned)) == ALL[:1] + ALL
    assert [row.utc for row in measured(listener.events).rows] == [
        event.utc for event in listener.of(Scanned)[1:]
    ]
    assert [event.text for event in listener.of(Alarm)] == [
        "at tester.load 20 N (point 2 of 3): tester: cable; try 1 of 2"
    ]


def test_the_completed_attempt_counts_when_the_next_one_is_interrupted():
    _, listener = scan_run(Press(), SCAN)
    repeated = [event for event in listener.events if isinstance(event, (StepStarted, Scanned))][:2]
    assert len(measured([*listener.events, *repeated]).rows) == len(LOADS)
    assert len(measured(repeated).rows) == 1


def test_stop_request_ends_the_scan_between_points():
    stop = threading.Event()

    def before(call):
        if call == "set load 20":
            stop.set()

    device = Press(before=before)
    summary, listener = scan_run(device, SCAN, stop=stop)
    assert summary.outcome is Outcome.ABORTED
    assert len(listener.of(Scanned)) == 2
    assert "set load 30" not in device.calls


def test_timeout_applies_to_the_whole_scan():
    scan = replace(SCAN, settle_s=0.4), Terms(timeout_s=1.0)
    summary, listener = scan_run(Press(), scan, clock=SimulatedClock())
    assert isinstance(summary.error, DeviceTimeoutError)
    assert len(listener.of(Scanned)) == 2


def test_no_point_starts_after_the_timeout():
    """Each reading takes 0.6 s; no wait in between would check the time as well."""
    clock = SimulatedClock()
    device = Press(before=lambda call: clock.sleep(0.6) if call.startswith("read t") else None)
    summary, listener = scan_run(device, (SCAN, Terms(timeout_s=1.0)), clock=clock)
    assert isinstance(summary.error, DeviceTimeoutError)
    assert len(listener.of(Scanned)) == 2
    assert "set load 30" not in device.calls


def test_scan_pauses_between_points():
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
    summary, listener = scan_run(device, SCAN, interlocks=[overload])
    assert "overload" in summary.reason or "above 0.015" in summary.reason
    assert len(listener.of(Scanned)) == 2
    assert "set load 30" not in device.calls


def test_channels_keep_the_order_of_the_step():
    scan = replace(SCAN, channels=(Member("tester", "torque"), Member("tester", "angle")))
    _, listener = scan_run(Press(), scan)
    assert {tuple(event.values) for event in listener.of(Scanned)} == {scan.channels}


def test_resume_after_a_scan_only_restores_the_drive():
    plan = plan_of(SCAN, SetDrive("tester", "frequency", 5.0, "Hz"), Settle(0.1), record("a"))
    listener = Listener()
    run(Press(), plan, critical=[listener])
    at = next(
        n for n, event in enumerate(listener.events)
        if isinstance(event, StepStarted) and event.step == "main[3]"
    )  # fmt: skip
    resume_at = find_resume_point(plan.steps, listener.events[: at + 1], "Ada")
    assert (resume_at.start, resume_at.before) == (3, (0, 1))
    back = restoring_step(plan.steps[0])
    assert back.action == SetDrive("tester", "load", 30.0, "N")
    assert back.text == "Set tester.load to 30 N, where the scan left it"
    device, resumed = Press(), Listener()
    run(device, plan, critical=[resumed], resume_at=resume_at)
    assert [c for c in device.calls if c.startswith("set load")] == ["set load 30"]
    assert not resumed.of(Scanned)
    assert len(measured([*listener.events[: at + 1], *resumed.events]).rows) == len(LOADS)
    assert streams_before(plan.steps, replace(resume_at, start=4)) == {
        "tester": [{"load": 30.0, "frequency": 5.0}]
    }


@pytest.mark.parametrize(("repeatable", "loads"), [(True, LOADS), (False, LOADS[-1:])])
def test_resume_repeats_a_scan_in_the_setup_if_repeatable(repeatable, loads):
    setup = PlannedStep("setup[0]", Phase.SETUP, SCAN, "", 1.0, Terms(repeatable=repeatable))
    plan = Plan((setup, PlannedStep("main[0]", Phase.MAIN, record("a"), "", 1.0)), ())
    listener = Listener()
    run(Press(), plan, critical=[listener])
    at = next(
        n for n, event in enumerate(listener.events) if getattr(event, "step", "") == "main[0]"
    )
    resume_at = find_resume_point(plan.steps, listener.events[: at + 1], "Ada")
    device, resumed = Press(), Listener()
    run(device, plan, critical=[resumed], resume_at=resume_at)
    assert [c for c in device.calls if c.startswith("set load")] == [
        f"set load {load:g}" for load in loads
    ]
    table = measured([*listener.events[: at + 1], *resumed.events]).rows
    assert [row.setpoints["tester.load"] for row in table] == list(LOADS)


def test_unrepeatable_scan_is_not_repeated_on_resume():
    once = (SCAN, Terms(repeatable=False))
    plan = plan_of(once, SetDrive("tester", "frequency", 5.0, "Hz"), record("a"))
    listener = Listener()
    run(Press(), plan, critical=[listener])
    steps = [n for n, event in enumerate(listener.events) if isinstance(event, StepStarted)]
    device, resumed = Press(), Listener()
    resume_at = find_resume_point(plan.steps, listener.events[: steps[2] + 1], "Ada")
    run(device, plan, critical=[resumed], resume_at=resume_at)
    assert [c for c in device.calls if c.startswith("set load")] == ["set load 30"]
    assert not resumed.of(Scanned)
    within = listener.events.index(listener.of(Scanned)[1])
    with pytest.raises(DataError, match=r"main\[0\] was interrupted, and must not be done twice"):
        find_resume_point(plan.steps, listener.events[: within + 1], "Ada")


def test_resume_within_a_scan_starts_it_over():
    plan = plan_of(SetDrive("tester", "frequency", 2.0, "Hz"), SCAN)
    listener = Listener()
    run(Press(), plan, critical=[listener])
    at = listener.events.index(listener.of(Scanned)[1])
    resume_at = find_resume_point(plan.steps, listener.events[: at + 1], "Ada")
    assert (resume_at.start, resume_at.before) == (1, (0,))
    resumed = Listener()
    run(Press(), plan, critical=[resumed], resume_at=resume_at)
    table = measured([*listener.events[: at + 1], *resumed.events]).rows
    assert [row.setpoints["tester.load"] for row in table] == list(LOADS)


def test_scan_of_a_blocking_device_is_the_same():
    device = Press(non_blocking=False)
    summary, listener = scan_run(device, SCAN)
    assert summary.outcome is Outcome.COMPLETED
    assert rows(listener.of(Scanned)) == ALL
    assert threading.main_thread().name not in device.threads


def test_scan_in_a_teardown_runs_after_a_stop():
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


def test_failing_sink_ends_the_scan_and_the_run():
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
    assert device.calls.count("set load 10") == 1  # not a failure of the step: not repeated
    assert len(events) == 1


def test_channels_of_two_devices_share_a_row():
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


def test_ctrl_c_within_a_scan_is_reported():
    def interrupt(call):
        if call == "set load 20":
            raise KeyboardInterrupt

    summary, _ = scan_run(FakeTester(before=interrupt), SCAN)
    assert summary.outcome is Outcome.ABORTED
    assert isinstance(summary.error, KeyboardInterrupt)


def test_rate_limited_drive_is_ramped_to_each_point():
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
